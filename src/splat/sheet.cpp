#include "splat/sheet.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <utility>

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
using D4 = hn::CappedTag<float, 4>;
using V = hn::Vec<D>;
using VI = hn::Vec<hn::RebindToSigned<D>>;

// The nearest whole number of what an int holds; sums are far from what it does not, which Highway would look for.
HWY_INLINE VI nearest(V v) {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
  return VI{_mm512_cvtps_epi32(v.raw)};
#elif HWY_ARCH_X86 && HWY_TARGET == HWY_AVX2
  return VI{_mm256_cvtps_epi32(v.raw)};
#elif HWY_ARCH_X86 && HWY_TARGET == HWY_SSE4
  return VI{_mm_cvtps_epi32(v.raw)};
#else
  return hn::NearestInt(v);
#endif
}

// A footprint's pixels, in the part of a sheet where it lies. kTaps is 0 where only the table knows how many.
template <int kTaps>
struct Footprint {
  const float *wide, *row, *down, *wide_down;
  int taps, padded;  // rows, and columns with the rest of vectors
  int x, y;          // the sheet's column and row of its first pixel
  Footprint(const FootprintTable& table, const FootprintPlace& at, const PixelRect& tile)
      : wide(table.wide(at.phaseX())),
        row(table.row(at.phaseX())),
        down(table.row(at.phaseY())),
        wide_down(table.wide(at.phaseY())),
        taps(kTaps > 0 ? kTaps : table.taps()),
        padded(kTaps > 0 ? kTaps : table.padded()),
        x(at.x()),
        y(at.y()) {
    if constexpr (kTaps == 0) {
      if (table.clipped()) clip(table.taps(), tile);
    }
  }

  // Leaves what of it is in the tile. The window of the tile's first pixel begins all but one of its pixels before it.
  void clip(int all, const PixelRect& tile) {
    x -= all - 1, y -= all - 1;
    const int left = std::max(-x, 0), above = std::max(-y, 0);
    wide += 4 * left, row += left, down += above;
    x += left, y += above;
    padded = std::min(all - left, tile.width() - x);
    taps = std::min(all - above, tile.height() - y);
  }

  // Four numbers a pixel: those of `four(i)`, from the i-th of four that repeat. Four pixels are one row of 16 numbers.
  template <class Four>
  HWY_INLINE void add(const Four& four, std::int32_t* to, std::ptrdiff_t stride) const {
    const D d;
    const hn::RebindToSigned<D> di;
    for (std::size_t i = 0; i < static_cast<std::size_t>(4 * padded); i += hn::Lanes(d)) {
      const V c = hn::Mul(hn::LoadU(d, wide + i), four(i));
      std::int32_t* at = to + i;
      for (int j = 0; j < taps; ++j, at += stride)
        hn::StoreU(hn::Add(hn::LoadU(di, at), nearest(hn::Mul(c, hn::Set(d, down[j])))), di, at);
    }
  }

  // One number a pixel.
  HWY_INLINE void addFilled(float fill, std::int32_t* to, std::ptrdiff_t stride) const {
    const D4 d;
    const hn::RebindToSigned<D4> di;
    if constexpr (kTaps == 3 || kTaps == 4) {
      // Four rows at once; of three the last is zeros.
      const D wide_d;
      alignas(64) std::int32_t parts[16];
      for (std::size_t i = 0; i < 16; i += hn::Lanes(wide_d)) {
        const V c = hn::Mul(fourOf(row, i), hn::Set(wide_d, fill));
        hn::Store(nearest(hn::Mul(c, hn::LoadU(wide_d, wide_down + i))), hn::RebindToSigned<D>(), parts + i);
      }
      for (int j = 0; j < kTaps; ++j, to += stride) {
        for (std::size_t i = 0; i < 4; i += hn::Lanes(d))
          hn::StoreU(hn::Add(hn::LoadU(di, to + i), hn::Load(di, parts + 4 * j + i)), di, to + i);
      }
      return;
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(padded); i += hn::Lanes(d)) {
      const auto c = hn::Mul(hn::LoadU(d, row + i), hn::Set(d, fill));
      std::int32_t* at = to + i;
      for (int j = 0; j < taps; ++j, at += stride)
        hn::StoreU(hn::Add(hn::LoadU(di, at), hn::NearestInt(hn::Mul(c, hn::Set(d, down[j])))), di, at);
    }
  }

  // Numbers i and on of four that repeat.
  HWY_INLINE static V fourOf(const float* four, [[maybe_unused]] std::size_t i) {
#if HWY_TARGET == HWY_SCALAR
    return hn::Load(D(), four + i % 4);
#else
    return hn::LoadDup128(D(), four);
#endif
  }
};

template <int kTaps>
void addSamplesOf(std::span<const SlabSample* const> samples, const FootprintTable& table, Sheet& here, Sheet& next) {
  using Taps = Footprint<kTaps>;
  const D d;
  alignas(16) static constexpr float kIsColor[4] = {1, 1, 1, 0};
  const float per_unit = 1 / here.colorUnit();
  for (const SlabSample* const s : samples) {
    const Taps footprint(table, s->place, here.rect());
    const auto add = [&](float amount, Sheet& sheet) {
      const float fill = amount * Sheet::kOne;
      const V scale = hn::Set(d, fill * s->opacity), of_color = hn::Set(d, fill * s->opacity * per_unit);
      const auto light = [&](std::size_t i) {
        const auto is_color = hn::Gt(Taps::fourOf(kIsColor, i), hn::Zero(d));
        return hn::IfThenElse(is_color, hn::Mul(of_color, Taps::fourOf(&s->r, i)), scale);
      };
      footprint.add(light, sheet.column(footprint.x, footprint.y), sheet.stride());
      footprint.addFilled(fill, sheet.filledColumn(footprint.x, footprint.y), sheet.stride() / 4);
    };
    if (s->front > 0) add(s->front, here);
    if (s->back > 0) add(s->back, next);
  }
}

template <int kTaps>
void addAovsOf(std::span<const AovSample* const> samples, const FootprintTable& table, Sheet& here, Sheet& next) {
  using Taps = Footprint<kTaps>;
  for (const AovSample* const s : samples) {
    const Taps footprint(table, s->place, here.rect());
    const auto add = [&](float amount, float depth, Sheet& sheet) {
      const float scale = amount * Sheet::kOne;
      alignas(16) const float sums[4] = {scale * s->normal.x, scale * s->normal.y, scale * s->normal.z, scale * depth};
      footprint.add([&](std::size_t i) { return Taps::fourOf(sums, i); }, sheet.column(footprint.x, footprint.y),
                    sheet.stride());
    };
    if (s->front > 0) add(s->front, s->depth_front, here);
    if (s->back > 0) add(s->back, s->depth_back, next);
  }
}

// Calls add(taps), where they are so few that loops over them are unrolled; taps of 0 else.
template <class Add>
HWY_INLINE void withTaps(const FootprintTable& footprint, Add&& add) {
  switch (footprint.taps()) {
    case 3:
      return add(std::integral_constant<int, 3>());
    case 4:
      return add(std::integral_constant<int, 4>());
    default:
      return add(std::integral_constant<int, 0>());
  }
}

void addSamplesOn(std::span<const SlabSample* const> samples, const FootprintTable& footprint, Sheet& here,
                  Sheet& next) {
  withTaps(footprint, [&](auto taps) { addSamplesOf<taps.value>(samples, footprint, here, next); });
}

void addAovsOn(std::span<const AovSample* const> samples, const FootprintTable& footprint, Sheet& here, Sheet& next) {
  withTaps(footprint, [&](auto taps) { addAovsOf<taps.value>(samples, footprint, here, next); });
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {
namespace {

constexpr double kTail = 0.2;  // unit: pixels, both tails

double normalBelow(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

}  // namespace

HWY_EXPORT(addSamplesOn);
HWY_EXPORT(addAovsOn);

FootprintTable::FootprintTable(double sigma_px, double soft_sigma_px, int least_taps) {
  const auto reachOf = [](double sigma) { return 3 * sigma + 0.5; };
  const double reach = reachOf(std::max(sigma_px, soft_sigma_px));
  // Pixels beyond half of the taps are out of reach. A tail of a thousandth is not worth another.
  taps_ = std::max(3, static_cast<int>(std::ceil(std::min<double>(2 * reach - kTail, kMostTaps))));
  radius_ = std::min(reach, 0.5 * taps_);
  const double most = radius_;
  taps_ = std::max(taps_, least_taps);
  coarser_ = taps_ <= 256 ? 0 : taps_ <= 1024 ? 2 : taps_ <= 4096 ? 4 : 6;
  for (const double sigma : {sigma_px, soft_sigma_px}) addRows(sigma, std::min(reachOf(sigma), most));
}

void FootprintTable::addRows(double sigma_px, double radius) {
  const int phases = kPhases >> coarser_;
  for (int phase = 0; phase < phases; ++phase) {
    // The sample is this far from the centre of the first pixel.
    const double from_first = (taps_ - 1) / 2 - 0.5 * (taps_ % 2) + (phase + 0.5) / phases;
    std::vector<double> w(static_cast<std::size_t>(taps_));
    double sum = 0, below = normalBelow((-from_first - 0.5) / sigma_px);
    for (int i = 0; i < taps_; ++i) {
      const double d = i - from_first, up_to = normalBelow((d + 0.5) / sigma_px);
      const double inside = up_to - std::exchange(below, up_to);
      if (std::abs(d) > radius) continue;
      w[static_cast<std::size_t>(i)] = inside;
      sum += inside;
    }
    for (const double v : w) {
      rows_.push_back(static_cast<float>(v / sum));
      wide_.insert(wide_.end(), 4, rows_.back());
    }
    rows_.resize(rows_.size() + static_cast<std::size_t>(padded() - taps_), 0.0f);
    wide_.resize(4 * rows_.size(), 0.0f);
  }
}

void Sheet::reset(const PixelRect& rect, const FootprintTable& footprint, float color_unit) {
  clear();
  color_unit_ = color_unit;
  const int before = footprint.clipped() ? 0 : footprint.taps() - 1;
  const int behind = footprint.clipped() ? kBlockEdge : footprint.padded();
  const int columns = before + (rect.width() + kBlockEdge - 1) / kBlockEdge * kBlockEdge + behind;
  // What is cleared is zero but for what nobody reads.
  const bool as_it_was =
      rect.width() == rect_.width() && rect.height() == rect_.height() && before == before_ && columns == width_;
  rect_ = rect;
  before_ = before;
  width_ = columns;
  if (as_it_was) return;
  sums_.assign(4 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(before + rect.height() + behind), 0);
  filled_.assign(sums_.size() / 4, 0);
}

void Sheet::clear() {
  for (std::uint64_t rest = dirty_; rest != 0; rest &= rest - 1) {
    const PixelRect area = blockRect(std::countr_zero(rest));
    for (int y = area.y0; y < area.y1; ++y) {
      const std::size_t first = indexOf(area.x0 - rect_.x0 + before_, y - rect_.y0 + before_);
      const auto count = static_cast<std::size_t>(area.width());
      std::fill_n(sums_.begin() + static_cast<std::ptrdiff_t>(4 * first), 4 * count, 0);
      std::fill_n(filled_.begin() + static_cast<std::ptrdiff_t>(first), count, 0);
    }
  }
  dirty_ = 0;
}

void addSamples(std::span<const SlabSample* const> samples, const FootprintTable& footprint, Sheet& here, Sheet& next) {
  HWY_DYNAMIC_DISPATCH(addSamplesOn)(samples, footprint, here, next);
}

void addAovs(std::span<const AovSample* const> samples, const FootprintTable& footprint, Sheet& here, Sheet& next) {
  HWY_DYNAMIC_DISPATCH(addAovsOn)(samples, footprint, here, next);
}

}  // namespace kiln
#endif
