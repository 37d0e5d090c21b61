#include "engine/voxel/rasterize_footprints.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/voxel/rasterize_footprints.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/voxel/voxel_weights-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

template <bool kAovs>
class FootprintRasterizer {
 public:
  FootprintRasterizer(const VoxelView& view, const ProjectedVoxels& voxels, const ShadedVoxels& shaded,
                      TilePlanes& planes, float opacity_threshold, Visibility& visibility)
      : view_(view),
        projected_(voxels),
        shaded_(shaded),
        planes_(planes),
        opacity_threshold_(opacity_threshold),
        visibility_(visibility),
        weighed_(view, voxels, shaded) {}

  void run(std::uint32_t drawn) {
    weighed_.prepare(drawn);
    view_.footprint != nullptr ? drawBatch<true>(drawn) : drawBatch<false>(drawn);
  }

 private:
  // Blends the voxels of a pixel in order, front to back.
  template <bool kOfTable>
  HWY_INLINE void drawBatch(std::uint32_t drawn) {
    if constexpr (!kOfTable) weighed_.weigh(drawn);
    if constexpr (!kAovs) {
      if (sharesRows<kOfTable>(drawn)) {
        drawTogether<kOfTable>(drawn);
        return;
      }
    }
    if constexpr (kOfTable) weighed_.weighByTable(drawn);
    forEachBit(drawn, [&](std::size_t n) { drawFootprint<kOfTable>(n); });
  }
  // Returns true if many voxels of the batch share few pixels per row, so that a row is better loaded and stored once
  // for all of them. Without a table opacities are already computed, and each row selects its part.
  template <bool kOfTable>
  bool sharesRows(std::uint32_t drawn) const {
    constexpr int kMostColumns = kOfTable ? 6 : 4, kLeastVoxels = 12;
    return !weighed_.anyLarge() && std::popcount(drawn) >= kLeastVoxels &&
           projected_.width(static_cast<std::size_t>(std::countr_zero(drawn))) <= kMostColumns;
  }

  // Draws footprint n. With kOfTable rows have eight pixels; pixels beyond the footprint have an opacity of zero.
  template <bool kOfTable>
  HWY_INLINE void drawFootprint(std::size_t n) {
    const PixelRect within = intersection(projected_.rect(n), planes_.rect());
    if (!kOfTable && weighed_.opacities(n) == nullptr) return drawLarge(n, within);
    const int columns = projected_.width(n), stride = kOfTable ? kWide : columns, x = projected_.x0[n];
    const float* row = weighed_.opacities(n) + (within.y0 - projected_.y0[n]) * stride;
    if constexpr (kAovs) {
      for (int y = within.y0; y < within.y1; ++y, row += stride) blendRow(n, row, x, columns, y);
    } else {
      const Brush brush(weighed_, n);
      const V8 opaque = hn::Set(D8(), opacity_threshold_);
      float* pixels = planes_.at(x, within.y0);
      unsigned closing[kPackedRows], any = 0;
      for (int y = within.y0; y < within.y1; ++y, row += stride, pixels += 4 * planes_.plane())
        any |= closing[y - within.y0] = blendEight<!kOfTable>(brush, opaque, row, columns, pixels);
      if (any == 0) return;
      for (int y = within.y0; y < within.y1; ++y) close(x, y, closing[y - within.y0]);
    }
  }

  // Draws a batch of overlapping footprints row by row. Pixels of a row stay in registers while voxel after voxel is
  // blended into them. Drawing voxel by voxel would spend most time on loads and stores, each waiting for the store
  // before it.
  template <bool kOfTable>
  HWY_INLINE void drawTogether(std::uint32_t drawn) {
    const PixelRect all = intersection(rectAround(projected_, drawn), planes_.rect());
    constexpr int kLanes = static_cast<int>(hn::MaxLanes(D8()));
    const bool is_thin = kOfTable && weighed_.areThin(drawn);
    for (int x = all.x0; x < all.x1; x += kLanes) {
      const std::uint32_t here =
          all.width() <= kLanes ? drawn : drawn & reaching(projected_.x0, projected_.x1, x, x + kLanes);
      for (int y = all.y0; y < all.y1; ++y) {
        const std::uint32_t of_row = here & reaching(projected_.y0, projected_.y1, y, y + 1);
        if (of_row == 0) continue;
        if (is_thin)
          drawRow<kOfTable, true>(of_row, x, y);
        else
          drawRow<kOfTable, false>(of_row, x, y);
      }
    }
  }

  // A vector of pixels in a row. A closed pixel has an alpha of one, so that blending adds nothing.
  struct Pixels {
    V8 red, green, blue, alpha;
  };
  // Colour of a footprint, equal for all its pixels.
  struct Brush {
    Brush(const WeighedVoxels& v, std::size_t n)
        : red(hn::Set(D8(), v.light(0, n))), green(hn::Set(D8(), v.light(1, n))), blue(hn::Set(D8(), v.light(2, n))) {}
    V8 red, green, blue;
  };
  // Blends the voxels of one row. A pixel that reaches the threshold takes nothing from later voxels. Its division by
  // alpha happens at the end of the row, so that the loop has no branch per pixel.
  template <bool kOfTable, bool kIsThin>
  HWY_INLINE void drawRow(std::uint32_t voxels, int x, int y) {
    const D8 d;
    float* const at = planes_.at(x, y);
    const std::ptrdiff_t plane = planes_.plane();
    Pixels pixels = load(at, plane);
    const V8 held = pixels.alpha, opaque = hn::Set(d, opacity_threshold_), one = hn::Set(d, 1.0f);
    if (hn::AllFalse(d, hn::Lt(held, one))) return;
    forEachBit(voxels, [&](std::size_t n) {
      const auto opacity = weighed_.template opacities<kOfTable, kIsThin>(n, x, y);
      blend(Brush(weighed_, n), hn::IfThenElseZero(hn::Lt(pixels.alpha, opaque), opacity), pixels);
    });
    const M8 closing = closingOf(held, pixels.alpha, opaque);
    std::uint32_t closed = bitsOf(d, closing);
    if (closed != 0) {
      const V8 full = hn::Div(one, hn::IfThenElse(closing, pixels.alpha, one));
      pixels = {hn::Mul(pixels.red, full), hn::Mul(pixels.green, full), hn::Mul(pixels.blue, full),
                hn::IfThenElse(closing, one, pixels.alpha)};
    }
    store(pixels, at, plane);
    for (; closed != 0; closed &= closed - 1) visibility_.close(x + std::countr_zero(closed), y);
  }
  HWY_INLINE static M8 closingOf(V8 held, V8 after, V8 opaque) {
    return hn::And(hn::Lt(held, hn::Set(D8(), 1.0f)), hn::Ge(after, opaque));
  }
  HWY_INLINE static Pixels load(const float* at, std::ptrdiff_t plane) {
    const D8 d;
    return {hn::LoadU(d, at), hn::LoadU(d, at + plane), hn::LoadU(d, at + 2 * plane), hn::LoadU(d, at + 3 * plane)};
  }
  HWY_INLINE static void store(const Pixels& pixels, float* at, std::ptrdiff_t plane) {
    const D8 d;
    hn::StoreU(pixels.red, d, at);
    hn::StoreU(pixels.green, d, at + plane);
    hn::StoreU(pixels.blue, d, at + 2 * plane);
    hn::StoreU(pixels.alpha, d, at + 3 * plane);
  }
  HWY_INLINE static void blend(const Brush& brush, V8 opacity, Pixels& to) {
    const V8 added = fusedLess(opacity, to.alpha, opacity);
    to.alpha = hn::Add(to.alpha, added);
    to.red = fused(added, brush.red, to.red);
    to.green = fused(added, brush.green, to.green);
    to.blue = fused(added, brush.blue, to.blue);
  }

  // Returns a mask of the voxels whose interval [first, last) intersects [begin, end).
  HWY_INLINE static std::uint32_t reaching(const std::int32_t* first, const std::int32_t* last, int begin, int end) {
    const DB d;
    std::uint32_t out = 0;
    for (std::size_t n = 0; n < kVoxelBatch; n += hn::Lanes(d)) {
      const auto reaches =
          hn::And(hn::Lt(hn::Load(d, first + n), hn::Set(d, end)), hn::Gt(hn::Load(d, last + n), hn::Set(d, begin)));
      out |= bitsOf(d, reaches) << n;
    }
    return out;
  }

  // Draws a footprint with more pixels, sixteen pixels of a row at a time.
  HWY_NOINLINE void drawLarge(std::size_t n, const PixelRect& within) {
    alignas(64) float chunk[kChunk];
    constexpr int kColumns = static_cast<int>(kChunk);
    const Brush brush(weighed_, n);
    const V8 opaque = hn::Set(D8(), opacity_threshold_);
    const int first = (within.x0 - projected_.x0[n]) / kColumns * kColumns;
    for (int y = within.y0; y < within.y1; ++y) {
      for (int i = first; i < within.x1 - projected_.x0[n]; i += kColumns) {
        weighed_.opacitiesOfChunk(n, i, y - projected_.y0[n], chunk);
        for (int k = 0; k < kColumns; k += kWide) {
          const int x = projected_.x0[n] + i + k;
          if (x + kWide <= within.x0 || x >= within.x1) continue;
          if constexpr (kAovs)
            blendRow(n, chunk + k, x, std::min(kWide, projected_.width(n) - i - k), y);
          else
            close(x, y, blendEight<false>(brush, opaque, chunk + k, kWide, planes_.at(x, y)));
        }
      }
    }
  }

  // Blends eight pixels, or with kPart the first `count` of them. Returns a mask of the pixels that reach the
  // threshold.
  template <bool kPart>
  HWY_INLINE unsigned blendEight(const Brush& brush, V8 opaque, const float* opacities, int count, float* at) const {
    const D8 d;
    const std::ptrdiff_t plane = planes_.plane();
    unsigned closing = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(kWide); i += hn::Lanes(d)) {
      V8 opacity = hn::LoadU(d, opacities + i);
      if constexpr (kPart) {
        const auto counted = hn::Lt(hn::Iota(d, static_cast<float>(i)), hn::Set(d, static_cast<float>(count)));
        opacity = hn::IfThenElseZero(counted, opacity);
      }
      Pixels pixels = load(at + i, plane);
      const V8 held = pixels.alpha;
      blend(brush, opacity, pixels);
      store(pixels, at + i, plane);
      closing |= bitsOf(d, closingOf(held, pixels.alpha, opaque)) << i;
    }
    return closing;
  }

  // Closes the pixels from (x, y) on whose bit is set: divides them by their alpha and sets alpha to one. Equation (7).
  HWY_INLINE void close(int x, int y, unsigned closing) {
    for (; closing != 0; closing &= closing - 1) closeOne(x + std::countr_zero(closing), y);
  }
  HWY_INLINE void closeOne(int x, int y) {
    float* const pixel = planes_.at(x, y);
    const std::ptrdiff_t plane = planes_.plane();
    const float full = 1.0f / pixel[3 * plane];
    for (std::ptrdiff_t c = 0; c < 3; ++c) pixel[c * plane] *= full;
    pixel[3 * plane] = 1.0f;
    visibility_.close(x, y);
  }

  // Blends a row pixel by pixel and adds AOVs. Skips pixels outside the tile, which belong to another thread.
  HWY_NOINLINE void blendRow(std::size_t n, const float* opacities, int x, int columns, int y) {
    const int end = std::min(planes_.rect().x1 - x, columns);
    const std::ptrdiff_t plane = planes_.plane();
    for (int i = std::max(planes_.rect().x0 - x, 0); i < end; ++i) {
      float* const pixel = planes_.at(x + i, y);
      const float before = pixel[3 * plane];
      if (!(before < 1)) continue;
      const float added = fused(-opacities[i], before, opacities[i]);
      for (std::ptrdiff_t c = 0; c < 3; ++c) pixel[c * plane] = fused(added, weighed_.light(c, n), pixel[c * plane]);
      pixel[3 * plane] = before + added;
      const bool closes = pixel[3 * plane] >= opacity_threshold_;
      addAovs(shaded_.aov[n], planes_.placeOf(x + i, y), before, added, closes);
      if (closes) closeOne(x + i, y);
    }
  }

  // Adds AOVs of a pixel whose alpha rose from `before` by `added` and is not closed yet.
  void addAovs(const VoxelAov& voxel, std::ptrdiff_t at, float before, float added, bool closes) const {
    const AovPixels& aovs = planes_.aovs();
    const float after = before + added;
    aovs.add(at, added * voxel.depth, added * voxel.normal, closes ? 1 / after : 1);
    if (aovs.first != nullptr && hitsFirst(before, after, closes)) aovs.first[at] = voxel.depth;
  }

  const VoxelView& view_;
  const ProjectedVoxels& projected_;
  const ShadedVoxels& shaded_;
  TilePlanes& planes_;
  const float opacity_threshold_;
  Visibility& visibility_;
  WeighedVoxels weighed_;
};

void rasterizeFootprintsOn(const VoxelView& view, const ProjectedVoxels& voxels, const ShadedVoxels& shaded,
                           std::uint32_t drawn, TilePlanes& planes, float opacity_threshold, Visibility& visibility) {
  planes.aovs().any()
      ? FootprintRasterizer<true>(view, voxels, shaded, planes, opacity_threshold, visibility).run(drawn)
      : FootprintRasterizer<false>(view, voxels, shaded, planes, opacity_threshold, visibility).run(drawn);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {

HWY_EXPORT(rasterizeFootprintsOn);

void rasterizeFootprints(const VoxelView& view, const ProjectedVoxels& voxels, const ShadedVoxels& shaded,
                         std::uint32_t drawn, TilePlanes& planes, float opacity_threshold,
                         Visibility& visibility) noexcept {
  HWY_DYNAMIC_DISPATCH(rasterizeFootprintsOn)(view, voxels, shaded, drawn, planes, opacity_threshold, visibility);
}

}  // namespace kiln
#endif
