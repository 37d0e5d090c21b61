#include "splat/voxel_footprint.h"

#include <algorithm>
#include <cmath>

namespace kiln {
namespace {

// Rounding must not put a pixel into a phase that the footprint does not reach: it would be drawn without having been
// asked about. unit: pixels.
constexpr double kRounding = 1e-4;

std::vector<float> weightsAlong(double half, int pixels) {
  const double sigma = half / kFootprintRadius;
  std::vector<float> out;
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
    : columns_(weightsAlong(static_cast<double>(ellipse.half_x), kColumns)),
      rows_(weightsAlong(static_cast<double>(ellipse.half_y), kRows)),
      most_(*std::max_element(columns_.begin(), columns_.end()) * *std::max_element(rows_.begin(), rows_.end())) {}

}  // namespace kiln
