#include "splat/sheet.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/sheet.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<D>;

// Four pixels of RGBA are one row of 16 numbers. shape: `width` pixels, a multiple of four, in `taps` rows.
HWY_INLINE void addRows(const float* wide, const float* down, int taps, int width, const float* color, std::int32_t* to,
                        std::ptrdiff_t stride) {
  const D d;
  const DI di;
  for (std::size_t i = 0; i < static_cast<std::size_t>(4 * width); i += hn::Lanes(d)) {
    const auto c = hn::Mul(hn::LoadU(d, wide + i), hn::LoadU(d, color + i % 16));
    std::int32_t* row = to + i;
    for (int j = 0; j < taps; ++j, row += stride)
      hn::StoreU(hn::Add(hn::LoadU(di, row), hn::NearestInt(hn::Mul(c, hn::Set(d, down[j])))), di, row);
  }
}

// What they fill: one number a pixel.
HWY_INLINE void addRow(const float* row, const float* down, int taps, int width, float fill, std::int32_t* to,
                       std::ptrdiff_t stride) {
  const hn::CappedTag<float, 4> d;
  const hn::RebindToSigned<decltype(d)> di;
  for (std::size_t i = 0; i < static_cast<std::size_t>(width); i += hn::Lanes(d)) {
    const auto c = hn::Mul(hn::LoadU(d, row + i), hn::Set(d, fill));
    std::int32_t* at = to + i;
    for (int j = 0; j < taps; ++j, at += stride)
      hn::StoreU(hn::Add(hn::LoadU(di, at), hn::NearestInt(hn::Mul(c, hn::Set(d, down[j])))), di, at);
  }
}

void addSamplesOn(std::span<const SlabSample> samples, const FootprintTable& footprint, Sheet& here, Sheet& next) {
  for (const SlabSample& s : samples) {
    int phase_x, phase_y;
    const int x0 = footprint.first(s.x, phase_x), y0 = footprint.first(s.y, phase_y);
    const float* const wide = footprint.wide(phase_x);
    const float* const down = footprint.weights(phase_y);
    alignas(64) float color[16];
    const auto add = [&](float amount, Sheet& sheet) {
      const float fill = amount * Sheet::kOne;
      const float scale = fill * s.opacity;
      for (int p = 0; p < 16; p += 4)
        color[p] = scale * s.r, color[p + 1] = scale * s.g, color[p + 2] = scale * s.b, color[p + 3] = scale;
      addRows(wide, down, footprint.taps(), footprint.padded(), color, sheet.at(x0, y0), sheet.stride());
      addRow(footprint.row(phase_x), down, footprint.taps(), footprint.padded(), fill, sheet.filledAt(x0, y0),
             sheet.stride() / 4);
    };
    if (s.front > 0) add(s.front, here);
    if (s.back > 0) add(s.back, next);
  }
}

void addAovsOn(std::span<const AovSample> samples, const FootprintTable& footprint, Sheet& here, Sheet& next) {
  for (const AovSample& s : samples) {
    int phase_x, phase_y;
    const int x0 = footprint.first(s.x, phase_x), y0 = footprint.first(s.y, phase_y);
    const auto add = [&](float amount, float depth, Sheet& sheet) {
      const float scale = amount * Sheet::kOne;
      alignas(64) float sums[16];
      for (int p = 0; p < 16; p += 4) {
        for (int axis = 0; axis < 3; ++axis) sums[p + axis] = scale * s.normal[axis];
        sums[p + 3] = scale * depth;
      }
      addRows(footprint.wide(phase_x), footprint.weights(phase_y), footprint.taps(), footprint.padded(), sums,
              sheet.at(x0, y0), sheet.stride());
    };
    if (s.front > 0) add(s.front, s.depth_front, here);
    if (s.back > 0) add(s.back, s.depth_back, next);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {
namespace {

double normalBelow(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

}  // namespace

HWY_EXPORT(addSamplesOn);
HWY_EXPORT(addAovsOn);

FootprintTable::FootprintTable(double sigma_px) {
  double reach = 3 * sigma_px + 0.5;
  // Four pixels are one vector: a tail of a thousandth is not worth another.
  if (reach < 2.1) reach = std::min(reach, 2.0);
  taps_ = 2 * std::max(2, static_cast<int>(std::ceil(reach)));
  radius_ = std::min(reach, 0.5 * taps_);
  for (int phase = 0; phase < kPhases; ++phase) {
    // The sample is this far from the centre of the first pixel.
    const double from_first = taps_ / 2 - 1 + (phase + 0.5) / kPhases;
    std::vector<double> w(static_cast<std::size_t>(taps_));
    double sum = 0;
    for (int i = 0; i < taps_; ++i) {
      const double d = i - from_first;
      if (std::abs(d) > reach) continue;
      w[static_cast<std::size_t>(i)] = normalBelow((d + 0.5) / sigma_px) - normalBelow((d - 0.5) / sigma_px);
      sum += w[static_cast<std::size_t>(i)];
    }
    for (const double v : w) {
      weights_.push_back(static_cast<float>(v / sum));
      wide_.insert(wide_.end(), 4, weights_.back());
    }
    rows_.insert(rows_.end(), weights_.end() - taps_, weights_.end());
    rows_.resize(static_cast<std::size_t>((phase + 1) * padded()), 0.0f);
    wide_.resize(static_cast<std::size_t>((phase + 1) * 4 * padded()), 0.0f);
  }
}

void Sheet::reset(const PixelRect& rect, int margin) {
  rect_ = rect;
  margin_ = margin;
  width_ = rect.x1 - rect.x0 + 2 * margin_;
  blocks_x_ = (rect.x1 - rect.x0 + 7) / 8;
  const int height = rect.y1 - rect.y0;
  sums_.assign(4 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height + 2 * margin_), 0);
  filled_.assign(sums_.size() / 4, 0);
  touched_.assign(static_cast<std::size_t>(blocks_x_) * static_cast<std::size_t>((height + 7) / 8), 0);
  dirty_.clear();
}

void Sheet::clear() {
  for (const std::int32_t block : dirty_) {
    const PixelRect area = blockRect(block);
    for (int y = area.y0; y < area.y1; ++y) {
      std::fill_n(at(area.x0, y), 4 * (area.x1 - area.x0), 0);
      std::fill_n(filledAt(area.x0, y), area.x1 - area.x0, 0);
    }
    touched_[static_cast<std::size_t>(block)] = 0;
  }
  dirty_.clear();
}

void addSamples(std::span<const SlabSample> samples, const FootprintTable& footprint, Sheet& here, Sheet& next) {
  HWY_DYNAMIC_DISPATCH(addSamplesOn)(samples, footprint, here, next);
}

void addAovs(std::span<const AovSample> samples, const FootprintTable& footprint, Sheet& here, Sheet& next) {
  HWY_DYNAMIC_DISPATCH(addAovsOn)(samples, footprint, here, next);
}

}  // namespace kiln
#endif
