// Error of a merging.
// Method. A sample is evenly filled between its depths, as compositing programs assume when they cut a sample: the
// front part t of a sample of alpha a has alpha 1 - (1 - a)^t, and colours in proportion.
// The error of a merged sample is largest at a border of its two parts, because the logarithm of transmittance is
// linear between borders, before and after merging.
// Invariant. The sum of the errors of all mergings that made a sample bounds the error of the sample.
#include "image/deep_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace kiln {
namespace {

constexpr std::size_t kAlpha = 3;

// Fraction of the light of a sample that comes from the front part t of its depth.
float partInFront(float alpha, float t) {
  if (t >= 1 || alpha >= 1) return 1;
  return alpha < 1e-4f ? t : -std::expm1(t * std::log1p(-alpha)) / alpha;
}

}  // namespace

DeepSamples::PackedError DeepSamples::packError(float v) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(v);
  return static_cast<PackedError>((bits >> 16) + ((bits & 0xffff) != 0 ? 1 : 0));
}

float DeepSamples::unpackError(PackedError v) { return std::bit_cast<float>(static_cast<std::uint32_t>(v) << 16); }

DeepSamples::MergedSample DeepSamples::merged(const MergedSample& a, const MergedSample& b) {
  MergedSample out = a;
  const float open = 1 - a.sample.rgba[kAlpha];
  out.sample.z_back = b.sample.z_back;
  for (std::size_t c = 0; c < 4; ++c) out.sample.rgba[c] += open * b.sample.rgba[c];
  // An opaque layer stays opaque in spite of rounding.
  if (b.sample.rgba[kAlpha] == 1) out.sample.rgba[kAlpha] = 1;
  out.error = a.merge_error;
  out.merge_error = b.merge_error;
  return out;
}

// `in_front`: transmittance of everything in front of `a`.
DeepSamples::PackedError DeepSamples::mergeError(const MergedSample& a, const MergedSample& b, float in_front) {
  const DeepSample both = merged(a, b).sample;
  const float depth = both.z_back - both.z;
  float most = 0;
  for (const float border : {a.sample.z_back, b.sample.z}) {
    const float part = partInFront(both.rgba[kAlpha], depth > 0 ? (border - both.z) / depth : 1);
    for (std::size_t c = 0; c < 4; ++c) most = std::max(most, std::abs(a.sample.rgba[c] - part * both.rgba[c]));
  }
  return packError(unpackError(a.error) + unpackError(b.error) + in_front * most);
}

DeepSamples::DeepSamples(const PixelRect& rect, const DeepBound& bound, double origin_depth)
    : bound_(bound), origin_depth_(origin_depth), lists_(rect) {}

std::uint64_t DeepSamples::bytesFor(std::uint64_t pixels, const DeepBound& bound) {
  return PixelLists<MergedSample>::bytesFor(pixels, bound.samples);
}

// Adds `sample` behind a full pixel, then merges the two neighbours with the least error. `open`: transmittance of
// everything in front of `sample`.
void DeepSamples::mergeLeast(int x, int y, const MergedSample& sample, float open) {
  std::array<MergedSample*, DeepBound::kMostSamples + 1> all{};
  std::size_t count = 0;
  lists_.forEach(x, y, [&](MergedSample& kept) { all[count++] = &kept; });
  MergedSample last = sample;
  all[count] = &last;
  const auto least = static_cast<std::size_t>(
      std::min_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count),
                       [](const MergedSample* a, const MergedSample* b) { return a->merge_error < b->merge_error; }) -
      all.begin());
  // Transmittance in front of each sample, computed from the back.
  for (std::size_t i = count; i-- > (least > 0 ? least - 1 : 0);) open /= 1 - all[i]->sample.rgba[kAlpha];
  *all[least] = merged(*all[least], *all[least + 1]);
  for (std::size_t i = least + 1; i < count; ++i) *all[i] = *all[i + 1];
  for (std::size_t i = least > 0 ? least - 1 : 0; i <= least && i + 1 < count; ++i) {
    all[i]->merge_error = mergeError(*all[i], *all[i + 1], open);
    open *= 1 - all[i]->sample.rgba[kAlpha];
  }
}

void DeepSamples::add(int x, int y, float z, float z_back, const float* before, const float* after) {
  const float open = 1 - before[kAlpha];
  if (!(open > 0) || std::equal(before, before + 4, after)) return;
  const int count = lists_.count(x, y);
  MergedSample sample{{z, z_back, {}}, 0, 0};
  for (std::size_t c = 0; c < 4; ++c) sample.sample.rgba[c] = std::max(after[c] - before[c], 0.0f) / open;
  float& alpha = sample.sample.rgba[kAlpha];
  alpha = after[kAlpha] >= 1 ? 1 : std::min(alpha, 1.0f);
  if (count > 0) {
    MergedSample& last = lists_.last(x, y);
    // Rounding must not move a layer into the layer before.
    sample.sample.z = std::max(z, last.sample.z_back);
    sample.sample.z_back = std::max(z_back, sample.sample.z);
    last.merge_error = mergeError(last, sample, open / (1 - last.sample.rgba[kAlpha]));
    if (unpackError(last.merge_error) <= bound_.error && bound_.error > 0) {
      last = merged(last, sample);
      return;
    }
  }
  if (count < bound_.samples)
    lists_.append(x, y, sample);
  else
    mergeLeast(x, y, sample, open);
}

void DeepSamples::copy(int x, int y, DeepSample* out) const {
  lists_.forEach(x, y, [&](const MergedSample& kept) {
    *out = kept.sample;
    out->z = static_cast<float>(out->z + origin_depth_);
    out->z_back = static_cast<float>(out->z_back + origin_depth_);
    ++out;
  });
}

}  // namespace kiln
