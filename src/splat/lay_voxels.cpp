#include "splat/lay_voxels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/lay_voxels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/sample_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

constexpr std::size_t kChunk = 16;  // pixels whose weights are found together
// A footprint of up to this many pixels is normalised by the sum of its weights; beyond, the sum is its integral to
// within 1e-3.
constexpr int kSmall = 256;

// Columns and rows of the pixels of footprints of up to eight columns, one row after the other without gaps: with gaps
// a footprint of five columns and rows would take three vectors, and so it takes two.
constexpr int kPacked = 8, kPackedRows = 16;
struct PackedPixels {
  alignas(64) float column[kPacked][kPacked * kPackedRows], row[kPacked][kPacked * kPackedRows];
};
constexpr PackedPixels kPixels = [] {
  PackedPixels out{};
  for (int width = 1; width <= kPacked; ++width) {
    for (int i = 0; i < kPacked * kPackedRows; ++i) {
      out.column[width - 1][i] = static_cast<float>(i % width);
      out.row[width - 1][i] = static_cast<float>(i / width);
    }
  }
  return out;
}();
// Of four pixels, the first so many.
alignas(16) constexpr float kFirst[4][4] = {{1, 1, 1, 1}, {1, 0, 0, 0}, {1, 1, 0, 0}, {1, 1, 1, 0}};

template <bool kAovs>
class VoxelLayer {
 public:
  VoxelLayer(const VoxelView& view, const ProjectedVoxels& voxels, const ShadedVoxels& shaded, const TilePixels& tile,
             float opaque_at, Visibility& visibility)
      : w_(view), p_(voxels), s_(shaded), tile_(tile), opaque_at_(opaque_at), visibility_(visibility) {}

  // Step by step for all of the batch, so that no voxel's sums and quotients keep the next one waiting; but blended one
  // after the other.
  void run(std::uint32_t drawn) {
    for (std::size_t n = 0; n < kVoxelBatch; n += hn::Lanes(D())) prepare(n);
    float* to = weights_;
    forEach(drawn, [&](std::size_t n) { to = weigh(n, to); });
    forEach(drawn, [&](std::size_t n) { makeOpaque(n); });
    forEach(drawn, [&](std::size_t n) { lay(n); });
  }

 private:
  // Of each voxel: the logarithm of a weight, to base 2, is xx dx² + xy dx dy + yy dy².
  struct Prepared {
    alignas(64) float xx[kVoxelBatch], xy[kVoxelBatch], yy[kVoxelBatch];
    alignas(64) float depth[kVoxelBatch];  // optical depth times pixels
    alignas(64) float light[4 * kVoxelBatch];
    float sum[kVoxelBatch];       // of weights
    float* weights[kVoxelBatch];  // then opacities; null where they are found row by row
  };

  template <class F>
  HWY_INLINE static void forEach(std::uint32_t bits, F f) {
    for (; bits != 0; bits &= bits - 1) f(static_cast<std::size_t>(std::countr_zero(bits)));
  }
  int width(std::size_t n) const { return p_.x1[n] - p_.x0[n]; }
  int height(std::size_t n) const { return p_.y1[n] - p_.y0[n]; }

  static constexpr float kHalfLog = -0.72134752f;  // of e, to base 2
  // The logarithm at the footprint's end.
  static constexpr float kLeastLog = kHalfLog * static_cast<float>(kFootprintRadius * kFootprintRadius);

  // A vector of voxels.
  HWY_INLINE void prepare(std::size_t n) {
    const D d;
    const V one = hn::Set(d, 1.0f);
    Sight sight{hn::Zero(d), hn::Zero(d), one};
    V depth = hn::Set(d, w_.length);
    if (w_.perspective) {
      sight.u = hn::Load(d, p_.u + n), sight.v = hn::Load(d, p_.v + n);
      sight.oblique = hn::Sqrt(hn::Add(one, hn::Add(hn::Mul(sight.u, sight.u), hn::Mul(sight.v, sight.v))));
      const V r = hn::Load(d, p_.r + n), squared = hn::Mul(r, r);
      depth = hn::Mul(hn::Mul(depth, squared), sight.oblique);
      ellipses(n, sight, squared);
    } else {
      hn::Store(hn::Set(d, kHalfLog * w_.ellipse.a), d, q_.xx + n);
      hn::Store(hn::Set(d, 2 * kHalfLog * w_.ellipse.b), d, q_.xy + n);
      hn::Store(hn::Set(d, kHalfLog * w_.ellipse.c), d, q_.yy + n);
    }
    V red, green, blue, tau;
    hn::LoadInterleaved4(d, s_.material + 4 * n, red, green, blue, tau);
    hn::Store(hn::Mul(tau, depth), d, q_.depth + n);
    if (w_.light.phong) {
      const Vector slope{hn::Load(d, s_.slope[0] + n), hn::Load(d, s_.slope[1] + n), hn::Load(d, s_.slope[2] + n)};
      V matte = one, gloss = hn::Zero(d);
      lightOn(d, w_.light, w_.perspective, slope, sight, matte, gloss);
      const auto lit = [&](V color) { return hn::Add(hn::Mul(color, matte), gloss); };
      red = lit(red), green = lit(green), blue = lit(blue);
    }
    hn::StoreInterleaved4(red, green, blue, one, d, q_.light + 4 * n);
  }

  HWY_INLINE void ellipses(std::size_t n, const Sight& sight, V squared) {
    const D d;
    const V xx = hn::Load(d, p_.xx + n), yy = hn::Load(d, p_.yy + n);
    const float* const c = w_.covariance;
    const V across = hn::Sub(hn::Mul(hn::Mul(sight.u, sight.v), hn::Set(d, c[5])),
                             hn::Add(hn::Mul(sight.v, hn::Set(d, c[3])), hn::Mul(sight.u, hn::Set(d, c[4]))));
    const V xy = hn::Mul(squared, hn::Add(hn::Set(d, c[1]), across));
    const V determinant = hn::Sub(hn::Mul(xx, yy), hn::Mul(xy, xy));
    const V scale = hn::Div(hn::Set(d, kHalfLog), determinant);
    hn::Store(hn::Mul(scale, yy), d, q_.xx + n);
    hn::Store(hn::Mul(hn::Set(d, -2.0f), hn::Mul(scale, xy)), d, q_.xy + n);
    hn::Store(hn::Mul(scale, xx), d, q_.yy + n);
  }

  // The weights of pixels by column and row.
  HWY_INLINE V weightsOf(std::size_t n, V column, V row, M in_footprint) const {
    const D d;
    const V dx = hn::Add(hn::Set(d, p_.dx[n]), column), dy = hn::Add(hn::Set(d, p_.dy[n]), row);
    const V across = hn::Add(hn::Mul(dx, hn::Set(d, q_.xx[n])), hn::Mul(dy, hn::Set(d, q_.xy[n])));
    const V log = hn::Add(hn::Mul(dx, across), hn::Mul(hn::Mul(dy, dy), hn::Set(d, q_.yy[n])));
    return hn::IfThenElseZero(hn::And(in_footprint, hn::Ge(log, hn::Set(d, kLeastLog))),
                              exp2Of(d, hn::Min(log, hn::Zero(d))));
  }

  // Finds the weights of a voxel and their sum; where they are few enough they are kept at `to`. The next one's place.
  HWY_INLINE float* weigh(std::size_t n, float* to) {
    const int columns = width(n), rows = height(n);
    if (HWY_LIKELY(columns <= kPacked && rows <= kPackedRows)) return weighPacked(n, to);
    q_.weights[n] = nullptr;
    q_.sum[n] = columns <= kSmall && rows <= kSmall && columns * rows <= kSmall ? sumOfRows(n) : areaOf(n);
    return to;
  }

  HWY_INLINE float* weighPacked(std::size_t n, float* to) {
    const D d;
    alignas(64) float sums[kChunk];
    const auto columns = static_cast<std::size_t>(width(n) - 1);
    const auto pixels = static_cast<std::size_t>(width(n) * height(n));
    const V rows = hn::Set(d, static_cast<float>(height(n)));
    for (std::size_t i = 0; i < kChunk; i += hn::Lanes(d)) {
      V sum = hn::Zero(d);
      for (std::size_t k = i; k < pixels; k += kChunk) {
        const V row = hn::Load(d, kPixels.row[columns] + k);
        const V weight = weightsOf(n, hn::Load(d, kPixels.column[columns] + k), row, hn::Lt(row, rows));
        hn::Store(weight, d, to + k);
        sum = hn::Add(sum, weight);
      }
      hn::Store(sum, d, sums + i);
    }
    q_.sum[n] = sumOf(sums);
    q_.weights[n] = to;
    std::fill_n(to + pixels, 4, 0.0f);  // the last row's last pixels are read by four, too
    return to + (pixels + kChunk - 1) / kChunk * kChunk;
  }

  // Of larger ones weights are found row by row, twice: for their sum, and when they are drawn.
  HWY_NOINLINE float sumOfRows(std::size_t n) const {
    const D d;
    alignas(64) float sums[kChunk] = {}, chunk[kChunk];
    for (int j = 0; j < height(n); ++j) {
      for (int i = 0; i < width(n); i += static_cast<int>(kChunk)) {
        weighChunk(n, i, j, chunk);
        for (std::size_t k = 0; k < kChunk; k += hn::Lanes(d))
          hn::Store(hn::Add(hn::Load(d, sums + k), hn::Load(d, chunk + k)), d, sums + k);
      }
    }
    return sumOf(sums);
  }
  HWY_INLINE void weighChunk(std::size_t n, int first, int row, float* to) const {
    const D d;
    const V end = hn::Set(d, static_cast<float>(width(n)));
    for (std::size_t k = 0; k < kChunk; k += hn::Lanes(d)) {
      const V column = hn::Iota(d, static_cast<float>(first + static_cast<int>(k)));
      hn::Store(weightsOf(n, column, hn::Set(d, static_cast<float>(row)), hn::Lt(column, end)), d, to + k);
    }
  }

  // Of every sixteenth weight to that of all.
  HWY_INLINE static float sumOf(const float* sums) {
    alignas(64) float eight[8], four[4];
    const hn::CappedTag<float, 8> d8;
    const hn::CappedTag<float, 4> d4;
    for (std::size_t i = 0; i < 8; i += hn::Lanes(d8))
      hn::Store(hn::Add(hn::Load(d8, sums + i), hn::Load(d8, sums + 8 + i)), d8, eight + i);
    for (std::size_t i = 0; i < 4; i += hn::Lanes(d4))
      hn::Store(hn::Add(hn::Load(d4, eight + i), hn::Load(d4, eight + 4 + i)), d4, four + i);
    return (four[0] + four[2]) + (four[1] + four[3]);
  }

  // The footprint's integral over the plane, cut off at the radius: 2 pi (1 - exp(-radius² / 2)) over the root of the
  // quadratic form's determinant.
  float areaOf(std::size_t n) const {
    const float a = q_.xx[n] / kHalfLog, b = q_.xy[n] / (2 * kHalfLog), c = q_.yy[n] / kHalfLog;
    return 6.21338519f / std::sqrt(a * c - b * b);
  }

  // From weights to opacities.
  HWY_INLINE void makeOpaque(std::size_t n) const {
    if (q_.weights[n] != nullptr) makeOpaque(n, q_.weights[n], static_cast<std::size_t>(width(n) * height(n)));
  }
  HWY_INLINE void makeOpaque(std::size_t n, float* weights, std::size_t count) const {
    const D d;
    const V scale = hn::Set(d, q_.sum[n] > 0 ? q_.depth[n] / q_.sum[n] : 0.0f);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d))
      hn::Store(opacityOf(d, hn::Mul(hn::Load(d, weights + i), scale)), d, weights + i);
  }

  HWY_INLINE void lay(std::size_t n) const {
    const PixelRect within = intersection(p_.rect(n), tile_.rect);
    if (q_.weights[n] == nullptr) return layLarge(n, within);
    const int columns = width(n), first = p_.x0[n], whole = columns & ~3, rest = columns & 3;
    const float* row = q_.weights[n] + (within.y0 - p_.y0[n]) * columns;
    float* pixels = pixelAt(first, within.y0);
    if (!kAovs && first >= tile_.rect.x0 && first + whole + (rest > 0 ? 4 : 0) <= tile_.rect.x1) {
      for (int y = within.y0; y < within.y1; ++y, row += columns, pixels += tile_.stride) {
        for (int i = 0; i < whole; i += 4) blendFour<false>(n, row + i, pixels + 4 * i, 4, first + i, y);
        if (rest > 0) blendFour<true>(n, row + whole, pixels + 4 * whole, rest, first + whole, y);
      }
      return;
    }
    for (int y = within.y0; y < within.y1; ++y, row += columns, pixels += tile_.stride)
      blendRow(n, row, pixels, first, columns, y);
  }

  // Sixteen pixels of a row at a time.
  HWY_NOINLINE void layLarge(std::size_t n, const PixelRect& within) const {
    alignas(64) float chunk[kChunk];
    constexpr int kColumns = static_cast<int>(kChunk);
    const int first = (within.x0 - p_.x0[n]) / kColumns * kColumns;
    for (int y = within.y0; y < within.y1; ++y) {
      for (int i = first; i < within.x1 - p_.x0[n]; i += kColumns) {
        const int x = p_.x0[n] + i;
        weighChunk(n, i, y - p_.y0[n], chunk);
        makeOpaque(n, chunk, kChunk);
        blendRow(n, chunk, pixelAt(x, y), x, std::min(kColumns, width(n) - i), y);
      }
    }
  }

  float* pixelAt(int x, int y) const {
    return tile_.rgba + (y - tile_.rect.y0) * tile_.stride + std::ptrdiff_t{4} * (x - tile_.rect.x0);
  }

  // Pixels of row y from x on, those beside the tile left out: they are another thread's.
  HWY_NOINLINE void blendRow(std::size_t n, const float* opacities, float* pixels, int x, int columns, int y) const {
    const int first = std::max(tile_.rect.x0 - x, 0), end = std::min(tile_.rect.x1 - x, columns);
    for (int i = first; i < end;) {
      if (!kAovs && i % 4 == 0 && i + 4 <= end) {
        blendFour<false>(n, opacities + i, pixels + 4 * i, 4, x + i, y);
        i += 4;
      } else {
        blendOne(n, opacities[i], pixels + 4 * i, x + i, y);
        ++i;
      }
    }
  }

  // The first `count` of four pixels of row y, from x on; kPart: they may be fewer than four.
  template <bool kPart>
  HWY_INLINE void blendFour(std::size_t n, const float* opacities, float* pixels, int count, int x, int y) const {
#if HWY_TARGET == HWY_SCALAR
    for (int i = 0; i < count; ++i) blendOne(n, opacities[i], pixels + 4 * i, x + i, y);
#else
    const D d;
    const V one = hn::Set(d, 1.0f), light = hn::LoadDup128(d, q_.light + 4 * n);
    for (std::size_t i = 0; i < 16; i += hn::Lanes(d)) {
      const V pixel = hn::LoadU(d, pixels + i), held = hn::Broadcast<3>(pixel);
      // A closed pixel has an alpha of one, and nothing is added to it.
      V opacity = eachFourTimes(opacities, i);
      if constexpr (kPart) opacity = hn::Mul(opacity, eachFourTimes(kFirst[count & 3], i));
      const V added = hn::Mul(opacity, hn::Sub(one, held));
      const M closing = hn::And(hn::Lt(held, one), hn::Ge(hn::Add(held, added), hn::Set(d, opaque_at_)));
      if (HWY_LIKELY(hn::AllFalse(d, closing))) {
        hn::StoreU(hn::Add(pixel, hn::Mul(added, light)), d, pixels + i);
      } else {
        for (std::size_t j = i / 4; j < std::min((i + hn::Lanes(d)) / 4, static_cast<std::size_t>(count)); ++j)
          blendOne(n, opacities[j], pixels + 4 * j, x + static_cast<int>(j), y);
      }
    }
#endif
  }

#if HWY_TARGET != HWY_SCALAR
  // Numbers i and on of four opacities, each for a pixel's four channels.
  HWY_INLINE static V eachFourTimes(const float* opacities, std::size_t i) {
    const D d;
    if constexpr (hn::MaxLanes(D()) <= 4) {
      return hn::Set(d, opacities[i / 4]);
    } else {
      alignas(64) static constexpr std::int32_t kPixel[16] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
      return hn::TableLookupLanes(hn::LoadDup128(d, opacities), hn::SetTableIndices(d, kPixel + i));
    }
  }
#endif

  // The same bits as blendFour for each of the four; and what is rare.
  HWY_NOINLINE void blendOne(std::size_t n, float opacity, float* pixel, int x, int y) const {
    const float before = pixel[3];
    if (!(before < 1)) return;
    const float added = opacity * (1.0f - before);
    for (std::size_t c = 0; c < 4; ++c) pixel[c] += added * q_.light[4 * n + c];
    const bool closes = pixel[3] >= opaque_at_;
    if constexpr (kAovs) addAovs(s_.aov[n], tile_.placeOf(x, y), before, added, closes);
    if (!closes) return;
    const float full = 1.0f / pixel[3];
    for (int c = 0; c < 3; ++c) pixel[c] *= full;
    pixel[3] = 1.0f;
    visibility_.close(x, y);
  }

  // A pixel's alpha was `before` and is more by `added`, not closed yet.
  void addAovs(const VoxelAov& voxel, std::ptrdiff_t at, float before, float added, bool closes) const {
    const float after = before + added;
    tile_.aovs.add(at, added * voxel.depth, added * voxel.normal, closes ? 1 / after : 1);
    if (tile_.aovs.first != nullptr && before < kHitAlpha && (after >= kHitAlpha || closes))
      tile_.aovs.first[at] = voxel.depth;
  }

  const VoxelView& w_;
  const ProjectedVoxels& p_;
  const ShadedVoxels& s_;
  const TilePixels& tile_;
  const float opaque_at_;
  Visibility& visibility_;
  Prepared q_;
  alignas(64) float weights_[kVoxelBatch * kPacked * kPackedRows + 4];
};

void layVoxelsOn(const VoxelView& view, const ProjectedVoxels& voxels, const ShadedVoxels& shaded, std::uint32_t drawn,
                 const TilePixels& tile, float opaque_at, Visibility& visibility) {
  tile.aovs.any() ? VoxelLayer<true>(view, voxels, shaded, tile, opaque_at, visibility).run(drawn)
                  : VoxelLayer<false>(view, voxels, shaded, tile, opaque_at, visibility).run(drawn);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {

HWY_EXPORT(layVoxelsOn);

void layVoxels(const VoxelView& view, const ProjectedVoxels& voxels, const ShadedVoxels& shaded, std::uint32_t drawn,
               const TilePixels& tile, float opaque_at, Visibility& visibility) noexcept {
  HWY_DYNAMIC_DISPATCH(layVoxelsOn)(view, voxels, shaded, drawn, tile, opaque_at, visibility);
}

}  // namespace kiln
#endif
