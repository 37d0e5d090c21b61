#include "splat/lay_voxels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/lay_voxels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/sample_math-inl.h"
#include "splat/voxel_batch-inl.h"

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
// Of a row, so many pixels are blended together; rows of footprint tables are as long.
constexpr int kWide = TilePlanes::kWide;
static_assert(VoxelFootprint::kColumns == kWide && VoxelFootprint::kRows <= kPackedRows);
using D8 = hn::CappedTag<float, static_cast<std::size_t>(kWide)>;
using V8 = hn::Vec<D8>;
using M8 = hn::Mask<D8>;

template <bool kAovs>
class VoxelLayer {
 public:
  VoxelLayer(const VoxelView& view, const ProjectedVoxels& voxels, const ShadedVoxels& shaded, TilePlanes& planes,
             float opaque_at, Visibility& visibility)
      : w_(view), p_(voxels), s_(shaded), planes_(planes), opaque_at_(opaque_at), visibility_(visibility) {}

  // Step by step for all of the batch, so that no voxel's sums and quotients keep the next one waiting; but in a pixel
  // they are blended one after the other.
  void run(std::uint32_t drawn) {
    const std::uint32_t of_vector = (1u << hn::Lanes(D())) - 1;
    for (std::size_t n = 0; n < kVoxelBatch; n += hn::Lanes(D())) {
      if ((drawn >> n & of_vector) != 0) prepare(n);
    }
    w_.footprint != nullptr ? runOf<true>(drawn) : runOf<false>(drawn);
  }

 private:
  // Of each voxel: the logarithm of a weight, to base 2, is xx dx² + xy dx dy + yy dy².
  struct Prepared {
    alignas(64) float xx[kVoxelBatch], xy[kVoxelBatch], yy[kVoxelBatch];
    alignas(64) std::int32_t column[kVoxelBatch], row[kVoxelBatch];  // phases of the footprint table
    alignas(64) float depth[kVoxelBatch];                            // optical depth times pixels
    alignas(64) float light[3][kVoxelBatch];
    float sum[kVoxelBatch];       // of weights
    float* weights[kVoxelBatch];  // then opacities; null where they are found row by row
  };

  template <bool kOfTable>
  HWY_INLINE void runOf(std::uint32_t drawn) {
    float* to = weights_ + kBeside;
    if constexpr (!kOfTable) {
      forEach(drawn, [&](std::size_t n) { to = weigh(n, to); });
      forEach(drawn, [&](std::size_t n) { makeOpaque(n); });
    }
    if constexpr (!kAovs) {
      if (sharesRows(drawn)) {
        layTogether<kOfTable>(drawn);
        return;
      }
    }
    if constexpr (kOfTable) forEach(drawn, [&](std::size_t n) { to = makeOpaqueOfTable(n, to); });
    forEach(drawn, [&](std::size_t n) { lay<kOfTable>(n); });
  }
  // Whether so many of a batch touch each row, and so few pixels of it, that it is worth being read and written but
  // once for all of them: of the few that are left where most is hidden, those rows cost more that pixels close in.
  bool sharesRows(std::uint32_t drawn) const {
    constexpr int kMostColumns = 4, kLeastVoxels = 12;
    return !any_large_ && std::popcount(drawn) >= kLeastVoxels &&
           width(static_cast<std::size_t>(std::countr_zero(drawn))) <= kMostColumns;
  }

  template <class F>
  HWY_INLINE static void forEach(std::uint32_t bits, F f) {
    for (; bits != 0; bits &= bits - 1) f(static_cast<std::size_t>(std::countr_zero(bits)));
  }
  int width(std::size_t n) const { return p_.x1[n] - p_.x0[n]; }
  int height(std::size_t n) const { return p_.y1[n] - p_.y0[n]; }

  static constexpr float kMostDepth = 1e30f;
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
    } else if (w_.footprint != nullptr) {
      phases(p_.dx + n, w_.ellipse.half_x, q_.column + n);
      phases(p_.dy + n, w_.ellipse.half_y, q_.row + n);
    } else {
      hn::Store(hn::Set(d, kHalfLog * w_.ellipse.a), d, q_.xx + n);
      hn::Store(hn::Set(d, 2 * kHalfLog * w_.ellipse.b), d, q_.xy + n);
      hn::Store(hn::Set(d, kHalfLog * w_.ellipse.c), d, q_.yy + n);
    }
    V red, green, blue, tau;
    hn::LoadInterleaved4(d, s_.material + 4 * n, red, green, blue, tau);
    // Where it is infinite, pixels beside the footprint, with a weight of zero, would be more than clear.
    depth = hn::Min(hn::Mul(tau, depth), hn::Set(d, kMostDepth));
    hn::Store(depth, d, q_.depth + n);
    if (w_.footprint != nullptr)
      thin_ |= bitsOf(d, hn::Le(hn::Mul(depth, hn::Set(d, w_.footprint->most())), hn::Set(d, kThin))) << n;
    if (w_.light.phong) {
      const Vector slope{hn::Load(d, s_.slope[0] + n), hn::Load(d, s_.slope[1] + n), hn::Load(d, s_.slope[2] + n)};
      V matte = one, gloss = hn::Zero(d);
      lightOn(d, w_.light, w_.perspective, slope, sight, matte, gloss);
      const auto lit = [&](V color) { return fused(color, matte, gloss); };
      red = lit(red), green = lit(green), blue = lit(blue);
    }
    hn::Store(red, d, q_.light[0] + n);
    hn::Store(green, d, q_.light[1] + n);
    hn::Store(blue, d, q_.light[2] + n);
  }

  // VoxelFootprint::phaseOf.
  HWY_INLINE static void phases(const float* from_centre, float half, std::int32_t* to) {
    const D d;
    const DI di;
    const V part = hn::Add(hn::Load(d, from_centre), hn::Set(d, half));
    const VI phase = hn::ConvertTo(di, hn::Mul(part, hn::Set(d, static_cast<float>(VoxelFootprint::kPhases))));
    hn::Store(hn::Min(hn::Max(phase, hn::Zero(di)), hn::Set(di, VoxelFootprint::kPhases - 1)), di, to);
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
    const V across = fused(dx, hn::Set(d, q_.xx[n]), hn::Mul(dy, hn::Set(d, q_.xy[n])));
    const V log = fused(dx, across, hn::Mul(hn::Mul(dy, dy), hn::Set(d, q_.yy[n])));
    return hn::IfThenElseZero(hn::And(in_footprint, hn::Ge(log, hn::Set(d, kLeastLog))),
                              exp2Of(d, hn::Min(log, hn::Zero(d))));
  }

  // Finds the weights of a voxel and their sum; where they are few enough they are kept at `to`. The next one's place.
  HWY_INLINE float* weigh(std::size_t n, float* to) {
    const int columns = width(n), rows = height(n);
    if (HWY_LIKELY(columns <= kPacked && rows <= kPackedRows)) return weighPacked(n, to);
    q_.weights[n] = nullptr;
    any_large_ = true;
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

  // Of every sixteenth weight to that of all: halves are added until one is left.
  HWY_INLINE static float sumOf(const float* sums) {
    const D8 d8;
    const hn::CappedTag<float, 4> d4;
    alignas(32) float eight[8];
    for (std::size_t i = 0; i < 8; i += hn::Lanes(d8))
      hn::Store(hn::Add(hn::Load(d8, sums + i), hn::Load(d8, sums + 8 + i)), d8, eight + i);
    alignas(16) float four[4];
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
    // No weight is above one.
    const float most = q_.sum[n] > 0 ? q_.depth[n] / q_.sum[n] : 0.0f;
    const V scale = hn::Set(d, most);
    if (most <= kThin) {
      for (std::size_t i = 0; i < count; i += hn::Lanes(d))
        hn::Store(opacityOfThin(d, hn::Mul(hn::Load(d, weights + i), scale)), d, weights + i);
      return;
    }
    for (std::size_t i = 0; i < count; i += hn::Lanes(d))
      hn::Store(opacityOf(d, hn::Mul(hn::Load(d, weights + i), scale)), d, weights + i);
  }

  // The opacities of a footprint out of the table, at `to`: eight a row. The next one's place.
  HWY_INLINE float* makeOpaqueOfTable(std::size_t n, float* to) {
    q_.weights[n] = to;
    return (thin_ >> n & 1) != 0 ? makeOpaqueOfTable<true>(n, to) : makeOpaqueOfTable<false>(n, to);
  }
  template <bool kIsThin>
  HWY_INLINE float* makeOpaqueOfTable(std::size_t n, float* to) const {
    const D8 d;
    const float* const columns = w_.footprint->columns(q_.column[n]);
    const float* const rows = w_.footprint->rows(q_.row[n]);
    for (int j = 0; j < height(n); ++j, to += kWide) {
      const V8 scale = hn::Set(d, q_.depth[n] * rows[j]);
      for (std::size_t i = 0; i < static_cast<std::size_t>(kWide); i += hn::Lanes(d)) {
        const V8 depth = hn::Mul(hn::LoadU(d, columns + i), scale);
        hn::Store(kIsThin ? opacityOfThin(d, depth) : opacityOf(d, depth), d, to + i);
      }
    }
    return to;
  }

  // kOfTable: rows are eight pixels, those beyond the footprint with an opacity of zero.
  template <bool kOfTable>
  HWY_INLINE void lay(std::size_t n) {
    const PixelRect within = intersection(p_.rect(n), planes_.rect());
    const int columns = width(n), stride = kOfTable ? kWide : columns, x = p_.x0[n];
    const float* row = q_.weights[n] + (within.y0 - p_.y0[n]) * stride;
    if (!kOfTable && q_.weights[n] == nullptr) {
      layLarge(n, within);
    } else if constexpr (kAovs) {
      for (int y = within.y0; y < within.y1; ++y, row += stride) blendRow(n, row, x, columns, y);
    } else {
      const Brush brush(q_, n);
      const V8 opaque = hn::Set(D8(), opaque_at_);
      float* pixels = planes_.at(x, within.y0);
      unsigned closing[kPackedRows], any = 0;
      for (int y = within.y0; y < within.y1; ++y, row += stride, pixels += 4 * planes_.plane())
        any |= closing[y - within.y0] = blendEight<!kOfTable>(brush, opaque, row, columns, pixels);
      if (any == 0) return;
      for (int y = within.y0; y < within.y1; ++y) close(x, y, closing[y - within.y0]);
    }
  }

  // Neighbours' footprints overlap: row by row of all that they touch, pixels stay in registers while one voxel after
  // the other is blended into them. Voxel by voxel each would wait for the row to be written by the one before, and
  // most of the work would be to read and to write.
  template <bool kOfTable>
  HWY_INLINE void layTogether(std::uint32_t drawn) {
    const PixelRect all = intersection(rectAround(p_, drawn), planes_.rect());
    constexpr int kLanes = static_cast<int>(hn::MaxLanes(D8()));
    const bool is_thin = kOfTable && (drawn & ~thin_) == 0;
    for (int x = all.x0; x < all.x1; x += kLanes) {
      const std::uint32_t here = all.width() <= kLanes ? drawn : drawn & reaching(p_.x0, p_.x1, x, x + kLanes);
      for (int y = all.y0; y < all.y1; ++y) {
        const std::uint32_t of_row = here & reaching(p_.y0, p_.y1, y, y + 1);
        if (of_row == 0) continue;
        if (is_thin)
          layRow<kOfTable, true>(of_row, x, y);
        else
          layRow<kOfTable, false>(of_row, x, y);
      }
    }
  }

  // A vector of a row's pixels. A closed one has an alpha of one, and nothing is added to it.
  struct Pixels {
    V8 red, green, blue, alpha;
  };
  // What all pixels of a footprint share.
  struct Brush {
    Brush(const Prepared& q, std::size_t n)
        : red(hn::Set(D8(), q.light[0][n])), green(hn::Set(D8(), q.light[1][n])), blue(hn::Set(D8(), q.light[2][n])) {}
    V8 red, green, blue;
  };
  template <bool kOfTable, bool kIsThin>
  HWY_INLINE void layRow(std::uint32_t voxels, int x, int y) {
    const D8 d;
    float* const at = planes_.at(x, y);
    const std::ptrdiff_t plane = planes_.plane();
    Pixels pixels = load(at, plane);
    const V8 held = pixels.alpha, opaque = hn::Set(d, opaque_at_);
    const M8 open = hn::Lt(held, hn::Set(d, 1.0f));
    if (hn::AllFalse(d, open)) return;
    // One that is half opaque is likely to be closed.
    if (hn::AllFalse(d, hn::And(open, hn::Ge(held, hn::Set(d, 0.5f))))) {
      forEach(voxels, [&](std::size_t n) { blend(Brush(q_, n), opacities<kOfTable, kIsThin>(n, x, y), pixels); });
      // No alpha becomes less: where none has reached the threshold, none had to be closed on the way.
      if (HWY_LIKELY(hn::AllFalse(d, closingOf(held, pixels.alpha, opaque)))) {
        store(pixels, at, plane);
        return;
      }
    }
    layClosing<kOfTable, kIsThin>(voxels, x, y);
  }
  // The same, with a look at each pixel after each voxel.
  template <bool kOfTable, bool kIsThin>
  HWY_NOINLINE void layClosing(std::uint32_t voxels, int x, int y) {
    const D8 d;
    float* const at = planes_.at(x, y);
    const std::ptrdiff_t plane = planes_.plane();
    const V8 one = hn::Set(d, 1.0f), opaque = hn::Set(d, opaque_at_);
    Pixels pixels = load(at, plane);
    unsigned closed = 0;
    forEach(voxels, [&](std::size_t n) {
      const auto held = pixels.alpha;
      blend(Brush(q_, n), opacities<kOfTable, kIsThin>(n, x, y), pixels);
      const auto closing = closingOf(held, pixels.alpha, opaque);
      if (HWY_LIKELY(hn::AllFalse(d, closing))) return;
      const auto full = hn::Div(one, pixels.alpha);
      const auto filled = [&](auto color) { return hn::IfThenElse(closing, hn::Mul(color, full), color); };
      pixels = {filled(pixels.red), filled(pixels.green), filled(pixels.blue),
                hn::IfThenElse(closing, one, pixels.alpha)};
      closed |= bitsOf(d, closing);
    });
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

  // Those of a voxel over the pixels from (x, y) on, zero beside its footprint. requires: row y has some of it.
  template <bool kOfTable, bool kIsThin>
  HWY_INLINE V8 opacities(std::size_t n, int x, int y) const {
    const D8 d;
    const int before = p_.x0[n] - x, row = y - p_.y0[n];
    if constexpr (kOfTable) {
      const float* const columns = w_.footprint->columns(q_.column[n]) - before;
      const float of_row = q_.depth[n] * w_.footprint->rows(q_.row[n])[row];
      const auto depth = hn::Mul(hn::LoadU(d, columns), hn::Set(d, of_row));
      return kIsThin || (thin_ >> n & 1) != 0 ? opacityOfThin(d, depth) : opacityOf(d, depth);
    } else {
      const int columns = width(n);
      const auto column = hn::Iota(d, static_cast<float>(-before));
      const auto within = hn::And(hn::Ge(column, hn::Zero(d)), hn::Lt(column, hn::Set(d, static_cast<float>(columns))));
      return hn::IfThenElseZero(within, hn::LoadU(d, q_.weights[n] + row * columns - before));
    }
  }

  // Bits of the voxels that reach into [begin, end), by where their footprints begin and end.
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

  // Sixteen pixels of a row at a time.
  HWY_NOINLINE void layLarge(std::size_t n, const PixelRect& within) {
    alignas(64) float chunk[kChunk];
    constexpr int kColumns = static_cast<int>(kChunk);
    const Brush brush(q_, n);
    const V8 opaque = hn::Set(D8(), opaque_at_);
    const int first = (within.x0 - p_.x0[n]) / kColumns * kColumns;
    for (int y = within.y0; y < within.y1; ++y) {
      for (int i = first; i < within.x1 - p_.x0[n]; i += kColumns) {
        weighChunk(n, i, y - p_.y0[n], chunk);
        makeOpaque(n, chunk, kChunk);
        for (int k = 0; k < kColumns; k += kWide) {
          const int x = p_.x0[n] + i + k;
          if (x + kWide <= within.x0 || x >= within.x1) continue;
          if constexpr (kAovs)
            blendRow(n, chunk + k, x, std::min(kWide, width(n) - i - k), y);
          else
            close(x, y, blendEight<false>(brush, opaque, chunk + k, kWide, planes_.at(x, y)));
        }
      }
    }
  }

  // Eight pixels, kPart: the first `count` of them; a bit for each that reaches the threshold.
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

  // Those of the pixels from (x, y) on that have their bit set are divided by their alpha, and take nothing more.
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

  // The same one by one, for what is told beside colours. Pixels beside the tile are left out: they are another
  // thread's.
  HWY_NOINLINE void blendRow(std::size_t n, const float* opacities, int x, int columns, int y) {
    const int end = std::min(planes_.rect().x1 - x, columns);
    const std::ptrdiff_t plane = planes_.plane();
    for (int i = std::max(planes_.rect().x0 - x, 0); i < end; ++i) {
      float* const pixel = planes_.at(x + i, y);
      const float before = pixel[3 * plane];
      if (!(before < 1)) continue;
      const float added = fused(-opacities[i], before, opacities[i]);
      for (std::ptrdiff_t c = 0; c < 3; ++c) pixel[c * plane] = fused(added, q_.light[c][n], pixel[c * plane]);
      pixel[3 * plane] = before + added;
      const bool closes = pixel[3 * plane] >= opaque_at_;
      addAovs(s_.aov[n], planes_.placeOf(x + i, y), before, added, closes);
      if (closes) closeOne(x + i, y);
    }
  }

  // A pixel's alpha was `before` and is more by `added`, not closed yet.
  void addAovs(const VoxelAov& voxel, std::ptrdiff_t at, float before, float added, bool closes) const {
    const AovPixels& aovs = planes_.aovs();
    const float after = before + added;
    aovs.add(at, added * voxel.depth, added * voxel.normal, closes ? 1 / after : 1);
    if (aovs.first != nullptr && before < kHitAlpha && (after >= kHitAlpha || closes)) aovs.first[at] = voxel.depth;
  }

  const VoxelView& w_;
  const ProjectedVoxels& p_;
  const ShadedVoxels& s_;
  TilePlanes& planes_;
  const float opaque_at_;
  Visibility& visibility_;
  Prepared q_;
  std::uint32_t thin_ = 0;  // bits of those whose opacities are opacityOfThin's, where weights are of a table
  bool any_large_ = false;  // whether weights of one are found row by row
  // A vector of pixels may begin before a footprint's row, and end behind it.
  static constexpr std::size_t kBeside = kChunk;
  alignas(64) float weights_[kBeside + kVoxelBatch * kPacked * kPackedRows + kBeside];
};

void layVoxelsOn(const VoxelView& view, const ProjectedVoxels& voxels, const ShadedVoxels& shaded, std::uint32_t drawn,
                 TilePlanes& planes, float opaque_at, Visibility& visibility) {
  planes.aovs().any() ? VoxelLayer<true>(view, voxels, shaded, planes, opaque_at, visibility).run(drawn)
                      : VoxelLayer<false>(view, voxels, shaded, planes, opaque_at, visibility).run(drawn);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {

HWY_EXPORT(layVoxelsOn);

void layVoxels(const VoxelView& view, const ProjectedVoxels& voxels, const ShadedVoxels& shaded, std::uint32_t drawn,
               TilePlanes& planes, float opaque_at, Visibility& visibility) noexcept {
  HWY_DYNAMIC_DISPATCH(layVoxelsOn)(view, voxels, shaded, drawn, planes, opaque_at, visibility);
}

}  // namespace kiln
#endif
