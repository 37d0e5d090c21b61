// What footprints of voxels put over pixels: light, weights and opacities of a batch. Compiled once for each
// instruction set; hence no #pragma once.
#if defined(KILN_SPLAT_VOXEL_WEIGHTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_SPLAT_VOXEL_WEIGHTS_INL_H
#undef KILN_SPLAT_VOXEL_WEIGHTS_INL_H
#else
#define KILN_SPLAT_VOXEL_WEIGHTS_INL_H
#endif

#include <hwy/highway.h>

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "engine/shared/sample_math-inl.h"
#include "engine/voxel/rasterize_footprints.h"
#include "engine/voxel/voxel_batch-inl.h"

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

// A batch, step by step for all of it, so that no voxel's sums and quotients keep the next one waiting. Where weights
// are of a table (`kOfTable`), opacities are found row by row, or those of a whole footprint.
class WeighedVoxels {
 public:
  WeighedVoxels(const VoxelView& view, const ProjectedVoxels& voxels, const ShadedVoxels& shaded)
      : w_(view), p_(voxels), s_(shaded) {}

  void prepare(std::uint32_t drawn) {
    const std::uint32_t of_vector = (1u << hn::Lanes(D())) - 1;
    for (std::size_t n = 0; n < kVoxelBatch; n += hn::Lanes(D())) {
      if ((drawn >> n & of_vector) != 0) prepareVector(n);
    }
  }

  // Of each its weights, or where they are too many their sum; then opacities.
  void weigh(std::uint32_t drawn) {
    float* to = weights_ + kBeside;
    forEachBit(drawn, [&](std::size_t n) { to = weighOne(n, to); });
    forEachBit(drawn, [&](std::size_t n) { makeOpaque(n); });
  }
  // The same out of the table: eight opacities a row.
  void weighByTable(std::uint32_t drawn) {
    float* to = weights_ + kBeside;
    forEachBit(drawn, [&](std::size_t n) { to = makeOpaqueOfTable(n, to); });
  }

  // Whether all of them are so thin that opacityOfThin is theirs, where weights are of the table.
  bool areThin(std::uint32_t drawn) const { return (drawn & ~thin_) == 0; }
  // Whether opacities of some are not kept but found row by row; those of voxel n that are, and null.
  bool anyLarge() const { return any_large_; }
  const float* opacities(std::size_t n) const { return q_.weights[n]; }
  float light(std::size_t channel, std::size_t n) const { return q_.light[channel][n]; }

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
      const int columns = p_.width(n);
      const auto column = hn::Iota(d, static_cast<float>(-before));
      const auto within = hn::And(hn::Ge(column, hn::Zero(d)), hn::Lt(column, hn::Set(d, static_cast<float>(columns))));
      return hn::IfThenElseZero(within, hn::LoadU(d, q_.weights[n] + row * columns - before));
    }
  }

  // Sixteen of a row from a column of the footprint on.
  HWY_INLINE void opacitiesOfChunk(std::size_t n, int first, int row, float* to) const {
    weighChunk(n, first, row, to);
    makeOpaque(n, to, kChunk);
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

  static constexpr float kMostDepth = 1e30f;
  static constexpr float kHalfLog = -0.72134752f;  // of e, to base 2
  // The logarithm at the footprint's end.
  static constexpr float kLeastLog = kHalfLog * static_cast<float>(kFootprintRadius * kFootprintRadius);

  // A vector of voxels.
  HWY_INLINE void prepareVector(std::size_t n) {
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
  HWY_INLINE float* weighOne(std::size_t n, float* to) {
    const int columns = p_.width(n), rows = p_.height(n);
    if (HWY_LIKELY(columns <= kPacked && rows <= kPackedRows)) return weighPacked(n, to);
    q_.weights[n] = nullptr;
    any_large_ = true;
    q_.sum[n] = columns <= kSmall && rows <= kSmall && columns * rows <= kSmall ? sumOfRows(n) : areaOf(n);
    return to;
  }

  HWY_INLINE float* weighPacked(std::size_t n, float* to) {
    const D d;
    alignas(64) float sums[kChunk];
    const auto columns = static_cast<std::size_t>(p_.width(n) - 1);
    const auto pixels = static_cast<std::size_t>(p_.width(n) * p_.height(n));
    const V rows = hn::Set(d, static_cast<float>(p_.height(n)));
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
    for (int j = 0; j < p_.height(n); ++j) {
      for (int i = 0; i < p_.width(n); i += static_cast<int>(kChunk)) {
        weighChunk(n, i, j, chunk);
        for (std::size_t k = 0; k < kChunk; k += hn::Lanes(d))
          hn::Store(hn::Add(hn::Load(d, sums + k), hn::Load(d, chunk + k)), d, sums + k);
      }
    }
    return sumOf(sums);
  }
  HWY_INLINE void weighChunk(std::size_t n, int first, int row, float* to) const {
    const D d;
    const V end = hn::Set(d, static_cast<float>(p_.width(n)));
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
    if (q_.weights[n] != nullptr) makeOpaque(n, q_.weights[n], static_cast<std::size_t>(p_.width(n) * p_.height(n)));
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
    for (int j = 0; j < p_.height(n); ++j, to += kWide) {
      const V8 scale = hn::Set(d, q_.depth[n] * rows[j]);
      for (std::size_t i = 0; i < static_cast<std::size_t>(kWide); i += hn::Lanes(d)) {
        const V8 depth = hn::Mul(hn::LoadU(d, columns + i), scale);
        hn::Store(kIsThin ? opacityOfThin(d, depth) : opacityOf(d, depth), d, to + i);
      }
    }
    return to;
  }

  const VoxelView& w_;
  const ProjectedVoxels& p_;
  const ShadedVoxels& s_;
  Prepared q_;
  std::uint32_t thin_ = 0;  // bits of those whose opacities are opacityOfThin's, where weights are of a table
  bool any_large_ = false;  // whether weights of one are found row by row
  // A vector of pixels may begin before a footprint's row, and end behind it.
  static constexpr std::size_t kBeside = kChunk;
  alignas(64) float weights_[kBeside + kVoxelBatch * kPacked * kPackedRows + kBeside];
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
