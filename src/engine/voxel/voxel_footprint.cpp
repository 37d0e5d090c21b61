#include "engine/voxel/voxel_footprint.h"

#include <algorithm>
#include <cmath>

namespace kiln {
namespace {

// Rounding must not put a pixel into a phase that the footprint does not reach: it would be drawn without having been
// asked about. unit: pixels.
constexpr double kRounding = 1e-4;

// shape: for each phase, `pixels` and as many zeros as are `beside`, which are before the first phase, too.
std::vector<float> weightsAlong(double half, int pixels, int beside) {
  const double sigma = half / kFootprintRadius;
  const auto zeros = static_cast<std::size_t>(beside);
  std::vector<float> out(zeros);
  for (int phase = 0; phase < VoxelFootprint::kPhases; ++phase) {
    const double first = (phase + 0.5) / VoxelFootprint::kPhases - half;
    const double last = half - 0.5 / VoxelFootprint::kPhases - kRounding;
    const auto weightOf = [&](int i) {
      const double at = (first + i) / sigma;
      return first + i <= last ? std::exp(-0.5 * at * at) : 0;
    };
    double sum = 0;
    for (int i = 0; i < pixels; ++i) sum += weightOf(i);
    // One that lies between two pixels' centres and reaches neither shows nothing.
    for (int i = 0; i < pixels; ++i) out.push_back(static_cast<float>(sum > 0 ? weightOf(i) / sum : 0));
    out.resize(out.size() + zeros);
  }
  return out;
}

}  // namespace

bool VoxelFootprint::fits(const Ellipse& ellipse) {
  // Of a product of Gaussians a mixed part as small as this changes nothing in single precision.
  const bool straight = std::abs(ellipse.b) <= 1e-6f * std::sqrt(ellipse.a * ellipse.c);
  // Of a width below n pixels, at most n have their centres within it.
  return straight && 2 * ellipse.half_x < kColumns && 2 * ellipse.half_y < kRows;
}

VoxelFootprint::VoxelFootprint(const Ellipse& ellipse)
    : columns_(weightsAlong(static_cast<double>(ellipse.half_x), kColumns, kBeside)),
      rows_(weightsAlong(static_cast<double>(ellipse.half_y), kRows, 0)),
      most_(*std::max_element(columns_.begin(), columns_.end()) * *std::max_element(rows_.begin(), rows_.end())) {}

}  // namespace kiln
