#include "engine/voxel/voxel_footprint.h"

#include <algorithm>
#include <cmath>

namespace kiln {
namespace {

// Margin at the footprint's end. Without it, rounding could give weight to a pixel outside the footprint's rectangle,
// whose visibility was not tested. unit: pixels.
constexpr double kRounding = 1e-4;

// Tabulates the weights along one axis. shape: `beside` zeros, then for each phase `pixels` weights and `beside` zeros.
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
    // A footprint between two pixel centres that reaches neither contributes nothing.
    for (int i = 0; i < pixels; ++i) out.push_back(static_cast<float>(sum > 0 ? weightOf(i) / sum : 0));
    out.resize(out.size() + zeros);
  }
  return out;
}

}  // namespace

bool VoxelFootprint::fits(const Ellipse& ellipse) {
  // A mixed term this small does not change a product of Gaussians in single precision.
  const bool straight = std::abs(ellipse.b) <= 1e-6f * std::sqrt(ellipse.a * ellipse.c);
  // An interval shorter than n pixels contains at most n pixel centres.
  return straight && 2 * ellipse.half_x < kColumns && 2 * ellipse.half_y < kRows;
}

VoxelFootprint::VoxelFootprint(const Ellipse& ellipse)
    : columns_(weightsAlong(static_cast<double>(ellipse.half_x), kColumns, kBeside)),
      rows_(weightsAlong(static_cast<double>(ellipse.half_y), kRows, 0)),
      most_(*std::max_element(columns_.begin(), columns_.end()) * *std::max_element(rows_.begin(), rows_.end())) {}

}  // namespace kiln
