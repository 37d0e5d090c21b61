#include "splat/unit_axis.h"

#include <algorithm>

#include "grid/part_inside.h"
#include "splat/cubic_weights.h"

namespace kiln {
namespace {

// Taps without weight are the base, and share its weight: zero times what is not finite would not be zero. Quarters
// added in pairs are the voxel itself to the bit.
void setTaps(CubicTaps& taps, std::size_t sample, int base, const CubicWeights<double>& weights) {
  const auto shares = std::count(weights.begin(), weights.end(), 0.0) + (weights[1] != 0 ? 1 : 0);
  for (std::size_t tap = 0; tap < 4; ++tap) {
    const bool own = tap != 1 && weights[tap] != 0;
    taps.at[tap][sample] = own ? base - 1 + static_cast<int>(tap) : base;
    taps.weight[tap][sample] = static_cast<float>(own ? weights[tap] : weights[1] / static_cast<double>(shares));
  }
}

}  // namespace

double Refinement::leastFromFace() const {
  int least = samples;
  for (int i = 0; i < samples; ++i) {
    const int beyond = kRefinedVoxels * (2 * i + 1) % (2 * samples);
    least = std::min({least, beyond, 2 * samples - beyond});
  }
  return 0.5 * least / samples;
}

bool unitHasRoom(const Refinement& refinement, int voxels) {
  const int samples = refinement.samples * voxels;
  return samples / kRefinedVoxels + (samples % kRefinedVoxels != 0 ? 2 : 0) <= kUnitSamples;
}

// In whole numbers, so that a sample in the middle of a voxel is that: sample i is at (2i + 1) kRefinedVoxels / 2n
// voxels.
UnitAxis::UnitAxis(const Refinement& refinement, int first, int voxels, Interpolation interpolation)
    : step(1 / refinement.ofVoxel()) {
  const int n = refinement.samples;
  // The first sample in this voxel's cube, or after it.
  const auto sampleFrom = [&](int voxel) { return (2 * n * voxel + kRefinedVoxels - 1) / (2 * kRefinedVoxels); };
  const int first_sample = sampleFrom(first);
  for (int v = 0; v <= kUnitVoxels; ++v)
    before[static_cast<std::size_t>(v)] = sampleFrom(first + std::min(v, voxels)) - first_sample;
  samples = before[static_cast<std::size_t>(voxels)];
  for (int i = 0; i < kUnitSamples; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const int halves = kRefinedVoxels * (2 * (first_sample + std::min(i, samples)) + 1);
    const int voxel = halves / (2 * n) - first;
    const int beyond = halves % (2 * n);
    const float within = static_cast<float>(beyond) / static_cast<float>(2 * n) - 0.5f;
    offset[at] = static_cast<float>(voxel) + within;
    const bool centre = beyond == n;
    const int down = within < 0 && !centre ? -1 : 0;
    base[at] = kUnitMargin + voxel + down;
    fraction[at] = centre ? 0.0f : within - static_cast<float>(down);
    if (interpolation == Interpolation::kLinear) continue;
    const double t = static_cast<double>(fraction[at]);
    setTaps(smooth, at, base[at], bSplineWeights(t));
    setTaps(slope, at, base[at], bSplineSlopeWeights(t));
    setTaps(value, at, base[at], interpolation == Interpolation::kCubic ? bSplineWeights(t) : catmullRomWeights(t));
  }
}

std::array<float, kUnitSamples> UnitAxis::partsBefore(double end) const {
  std::array<float, kUnitSamples> out{};
  for (int i = 0; i < kUnitSamples; ++i) {
    const double from = static_cast<double>(offset[0]) + 0.5 + (i - 0.5) * step;
    out[static_cast<std::size_t>(i)] = static_cast<float>(partInside((end - from) / step));
  }
  return out;
}

}  // namespace kiln
