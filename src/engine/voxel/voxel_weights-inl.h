// Light, pixel weights and opacities of a batch of footprints; README.md, equations (2) to (5). Compiled once for each
// instruction set; hence no #pragma once.
#if defined(KILN_VOXEL_WEIGHTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_VOXEL_WEIGHTS_INL_H
#undef KILN_VOXEL_WEIGHTS_INL_H
#else
#define KILN_VOXEL_WEIGHTS_INL_H
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

constexpr std::size_t kChunk = 16;  // pixels weighted together
// Largest footprint that is normalised by the sum of its weights. Beyond it the integral replaces the sum, with a
// relative error of at most 1e-3. unit: pixels.
constexpr int kSmall = 256;

// Column and row of each pixel in a footprint of up to eight columns, stored row by row without gaps. Without gaps a
// footprint of 5×5 pixels takes two vectors instead of three.
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
// Pixels of a row that are blended together; also the length of a row in the footprint tables.
constexpr int kWide = TilePlanes::kWide;
static_assert(VoxelFootprint::kColumns == kWide && VoxelFootprint::kRows <= kPackedRows);
using D8 = hn::CappedTag<float, static_cast<std::size_t>(kWide)>;
using V8 = hn::Vec<D8>;
using M8 = hn::Mask<D8>;

// Light, weights and opacities of a batch. Each step handles all voxels before the next step begins, so that sums and
// quotients of different voxels overlap in the pipeline. With a table (`kOfTable`) opacities are computed either row by
// row or for a whole footprint.
class WeighedVoxels {
 public:
  WeighedVoxels(const VoxelView& view, const ProjectedVoxels& voxels, const ShadedVoxels& shaded)
      : view_(view), projected_(voxels), shaded_(shaded) {}

  void prepare(std::uint32_t drawn) {
    const std::uint32_t of_vector = (1u << hn::Lanes(D())) - 1;
    for (std::size_t n = 0; n < kVoxelBatch; n += hn::Lanes(D())) {
      if ((drawn >> n & of_vector) != 0) prepareVector(n);
    }
  }

  // Computes weights, or only their sum if a footprint has too many pixels, and then opacities.
  void weigh(std::uint32_t drawn) {
    float* to = weights_ + kBeside;
    forEachBit(drawn, [&](std::size_t n) { to = weighFootprint(n, to); });
    forEachBit(drawn, [&](std::size_t n) { makeOpaque(n); });
  }
  // Computes opacities from the table, eight per row.
  void weighByTable(std::uint32_t drawn) {
    float* to = weights_ + kBeside;
    forEachBit(drawn, [&](std::size_t n) { to = makeOpaqueByTable(n, to); });
  }

  // Returns true if all drawn voxels are thin enough for opacityOfThin. Only meaningful with a table.
  bool areThin(std::uint32_t drawn) const { return (drawn & ~thin_) == 0; }
  // Returns true if opacities of some footprint are not stored but computed row by row; opacities(n) is null for such a
  // voxel.
  bool anyLarge() const { return any_large_; }
  const float* opacities(std::size_t n) const { return prepared_.weights[n]; }
  float light(std::size_t channel, std::size_t n) const { return prepared_.light[channel][n]; }

  // Opacities of voxel n at the pixels from (x, y) on, zero outside its footprint. requires: row y intersects the
  // footprint.
  template <bool kOfTable, bool kIsThin>
  HWY_INLINE V8 opacities(std::size_t n, int x, int y) const {
    const D8 d;
    const int before = projected_.x0[n] - x, row = y - projected_.y0[n];
    if constexpr (kOfTable) {
      const float* const columns = view_.footprint->columns(prepared_.column[n]) - before;
      const float of_row = prepared_.depth[n] * view_.footprint->rows(prepared_.row[n])[row];
      const auto depth = hn::Mul(hn::LoadU(d, columns), hn::Set(d, of_row));
      return kIsThin || (thin_ >> n & 1) != 0 ? opacityOfThin(d, depth) : opacityOf(d, depth);
    } else {
      const int columns = projected_.width(n);
      const auto column = hn::Iota(d, static_cast<float>(-before));
      const auto within = hn::And(hn::Ge(column, hn::Zero(d)), hn::Lt(column, hn::Set(d, static_cast<float>(columns))));
      return hn::IfThenElseZero(within, hn::LoadU(d, prepared_.weights[n] + row * columns - before));
    }
  }

  // Computes sixteen opacities of a row, starting at column `first` of the footprint.
  HWY_INLINE void opacitiesOfChunk(std::size_t n, int first, int row, float* to) const {
    weighChunk(n, first, row, to);
    makeOpaque(n, to, kChunk);
  }

 private:
  // Intermediate results per voxel. The base-2 logarithm of a weight is xx dx² + xy dx dy + yy dy².
  struct Prepared {
    alignas(64) float xx[kVoxelBatch], xy[kVoxelBatch], yy[kVoxelBatch];
    alignas(64) std::int32_t column[kVoxelBatch], row[kVoxelBatch];  // phases of the footprint table
    alignas(64) float depth[kVoxelBatch];                            // optical depth times pixels
    alignas(64) float light[3][kVoxelBatch];
    float sum[kVoxelBatch];       // sum of the weights
    float* weights[kVoxelBatch];  // weights, later opacities; null if computed row by row
  };

  static constexpr float kMostDepth = 1e30f;
  static constexpr float kHalfLog = -0.72134752f;  // -1/2 log2(e)
  // Base-2 logarithm of the weight at the footprint's end.
  static constexpr float kEndLog = kHalfLog * static_cast<float>(kFootprintRadius * kFootprintRadius);

  // Prepares one vector of voxels.
  HWY_INLINE void prepareVector(std::size_t n) {
    const D d;
    const V one = hn::Set(d, 1.0f);
    Sight sight{hn::Zero(d), hn::Zero(d), one};
    V depth = hn::Set(d, view_.length);
    if (view_.perspective) {
      sight.u = hn::Load(d, projected_.u + n), sight.v = hn::Load(d, projected_.v + n);
      sight.oblique = hn::Sqrt(hn::Add(one, hn::Add(hn::Mul(sight.u, sight.u), hn::Mul(sight.v, sight.v))));
      const V r = hn::Load(d, projected_.r + n), squared = hn::Mul(r, r);
      depth = hn::Mul(hn::Mul(depth, squared), sight.oblique);
      ellipses(n, sight, squared);
    } else if (view_.footprint != nullptr) {
      phases(projected_.dx + n, view_.ellipse.half_x, prepared_.column + n);
      phases(projected_.dy + n, view_.ellipse.half_y, prepared_.row + n);
    } else {
      hn::Store(hn::Set(d, kHalfLog * view_.ellipse.a), d, prepared_.xx + n);
      hn::Store(hn::Set(d, 2 * kHalfLog * view_.ellipse.b), d, prepared_.xy + n);
      hn::Store(hn::Set(d, kHalfLog * view_.ellipse.c), d, prepared_.yy + n);
    }
    V red, green, blue, tau;
    hn::LoadInterleaved4(d, shaded_.material + 4 * n, red, green, blue, tau);
    // With infinite depth, a pixel outside the footprint (weight 0) would get an opacity of NaN.
    depth = hn::Min(hn::Mul(tau, depth), hn::Set(d, kMostDepth));
    hn::Store(depth, d, prepared_.depth + n);
    if (view_.footprint != nullptr)
      thin_ |= bitsOf(d, hn::Le(hn::Mul(depth, hn::Set(d, view_.footprint->most())), hn::Set(d, kThin))) << n;
    if (view_.light.phong) {
      const Vector slope{hn::Load(d, shaded_.slope[0] + n), hn::Load(d, shaded_.slope[1] + n),
                         hn::Load(d, shaded_.slope[2] + n)};
      V matte = one, gloss = hn::Zero(d);
      lightOn(d, view_.light, view_.perspective, slope, sight, matte, gloss);
      const auto lit = [&](V color) { return fused(color, matte, gloss); };
      red = lit(red), green = lit(green), blue = lit(blue);
    }
    hn::Store(red, d, prepared_.light[0] + n);
    hn::Store(green, d, prepared_.light[1] + n);
    hn::Store(blue, d, prepared_.light[2] + n);
  }

  // Vector form of VoxelFootprint::phaseOf.
  HWY_INLINE static void phases(const float* from_centre, float half, std::int32_t* to) {
    const D d;
    const DI di;
    const V part = hn::Add(hn::Load(d, from_centre), hn::Set(d, half));
    const VI phase = hn::ConvertTo(di, hn::Mul(part, hn::Set(d, static_cast<float>(VoxelFootprint::kPhases))));
    hn::Store(hn::Min(hn::Max(phase, hn::Zero(di)), hn::Set(di, VoxelFootprint::kPhases - 1)), di, to);
  }

  HWY_INLINE void ellipses(std::size_t n, const Sight& sight, V squared) {
    const D d;
    const V xx = hn::Load(d, projected_.xx + n), yy = hn::Load(d, projected_.yy + n);
    const float* const c = view_.covariance;
    const V across = hn::Sub(hn::Mul(hn::Mul(sight.u, sight.v), hn::Set(d, c[5])),
                             hn::Add(hn::Mul(sight.v, hn::Set(d, c[3])), hn::Mul(sight.u, hn::Set(d, c[4]))));
    const V xy = hn::Mul(squared, hn::Add(hn::Set(d, c[1]), across));
    const V determinant = hn::Sub(hn::Mul(xx, yy), hn::Mul(xy, xy));
    const V scale = hn::Div(hn::Set(d, kHalfLog), determinant);
    hn::Store(hn::Mul(scale, yy), d, prepared_.xx + n);
    hn::Store(hn::Mul(hn::Set(d, -2.0f), hn::Mul(scale, xy)), d, prepared_.xy + n);
    hn::Store(hn::Mul(scale, xx), d, prepared_.yy + n);
  }

  // Weights of the pixels at `column` and `row` of the footprint. Equation (3).
  HWY_INLINE V weightsOf(std::size_t n, V column, V row, M in_footprint) const {
    const D d;
    const V dx = hn::Add(hn::Set(d, projected_.dx[n]), column), dy = hn::Add(hn::Set(d, projected_.dy[n]), row);
    const V across = fused(dx, hn::Set(d, prepared_.xx[n]), hn::Mul(dy, hn::Set(d, prepared_.xy[n])));
    const V log = fused(dx, across, hn::Mul(hn::Mul(dy, dy), hn::Set(d, prepared_.yy[n])));
    return hn::IfThenElseZero(hn::And(in_footprint, hn::Ge(log, hn::Set(d, kEndLog))),
                              exp2Of(d, hn::Min(log, hn::Zero(d))));
  }

  // Computes the weights of a voxel and their sum. Stores small sets of weights at `to`. Returns the next free
  // position.
  HWY_INLINE float* weighFootprint(std::size_t n, float* to) {
    const int columns = projected_.width(n), rows = projected_.height(n);
    if (HWY_LIKELY(columns <= kPacked && rows <= kPackedRows)) return weighPacked(n, to);
    prepared_.weights[n] = nullptr;
    any_large_ = true;
    prepared_.sum[n] = columns <= kSmall && rows <= kSmall && columns * rows <= kSmall ? sumOfRows(n) : areaOf(n);
    return to;
  }

  HWY_INLINE float* weighPacked(std::size_t n, float* to) {
    const D d;
    alignas(64) float sums[kChunk];
    const auto columns = static_cast<std::size_t>(projected_.width(n) - 1);
    const auto pixels = static_cast<std::size_t>(projected_.width(n) * projected_.height(n));
    const V rows = hn::Set(d, static_cast<float>(projected_.height(n)));
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
    prepared_.sum[n] = sumOf(sums);
    prepared_.weights[n] = to;
    return to + (pixels + kChunk - 1) / kChunk * kChunk;
  }

  // Footprints with more pixels compute their weights twice, row by row: for the sum, and again when they are drawn.
  HWY_NOINLINE float sumOfRows(std::size_t n) const {
    const D d;
    alignas(64) float sums[kChunk] = {}, chunk[kChunk];
    for (int j = 0; j < projected_.height(n); ++j) {
      for (int i = 0; i < projected_.width(n); i += static_cast<int>(kChunk)) {
        weighChunk(n, i, j, chunk);
        for (std::size_t k = 0; k < kChunk; k += hn::Lanes(d))
          hn::Store(hn::Add(hn::Load(d, sums + k), hn::Load(d, chunk + k)), d, sums + k);
      }
    }
    return sumOf(sums);
  }
  HWY_INLINE void weighChunk(std::size_t n, int first, int row, float* to) const {
    const D d;
    const V end = hn::Set(d, static_cast<float>(projected_.width(n)));
    for (std::size_t k = 0; k < kChunk; k += hn::Lanes(d)) {
      const V column = hn::Iota(d, static_cast<float>(first + static_cast<int>(k)));
      hn::Store(weightsOf(n, column, hn::Set(d, static_cast<float>(row)), hn::Lt(column, end)), d, to + k);
    }
  }

  // Adds sixteen partial sums by halving, in a fixed order.
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

  // Integral of the footprint over the plane, cut off at the radius: 2 π (1 - exp(-radius² / 2)) / sqrt(determinant of
  // the quadratic form).
  float areaOf(std::size_t n) const {
    const float a = prepared_.xx[n] / kHalfLog, b = prepared_.xy[n] / (2 * kHalfLog), c = prepared_.yy[n] / kHalfLog;
    return 6.21338519f / std::sqrt(a * c - b * b);
  }

  // Replaces weights by opacities. Equations (4) and (5).
  HWY_INLINE void makeOpaque(std::size_t n) const {
    if (prepared_.weights[n] != nullptr)
      makeOpaque(n, prepared_.weights[n], static_cast<std::size_t>(projected_.width(n) * projected_.height(n)));
  }
  HWY_INLINE void makeOpaque(std::size_t n, float* weights, std::size_t count) const {
    const D d;
    // No weight exceeds one, so this is an upper bound of the optical depth.
    const float most = prepared_.sum[n] > 0 ? prepared_.depth[n] / prepared_.sum[n] : 0.0f;
    const V scale = hn::Set(d, most);
    if (most <= kThin) {
      for (std::size_t i = 0; i < count; i += hn::Lanes(d))
        hn::Store(opacityOfThin(d, hn::Mul(hn::Load(d, weights + i), scale)), d, weights + i);
      return;
    }
    for (std::size_t i = 0; i < count; i += hn::Lanes(d))
      hn::Store(opacityOf(d, hn::Mul(hn::Load(d, weights + i), scale)), d, weights + i);
  }

  // Stores the opacities of a footprint from the table at `to`, eight per row. Returns the next free position.
  HWY_INLINE float* makeOpaqueByTable(std::size_t n, float* to) {
    prepared_.weights[n] = to;
    return (thin_ >> n & 1) != 0 ? makeOpaqueByTable<true>(n, to) : makeOpaqueByTable<false>(n, to);
  }
  template <bool kIsThin>
  HWY_INLINE float* makeOpaqueByTable(std::size_t n, float* to) const {
    const D8 d;
    const float* const columns = view_.footprint->columns(prepared_.column[n]);
    const float* const rows = view_.footprint->rows(prepared_.row[n]);
    for (int j = 0; j < projected_.height(n); ++j, to += kWide) {
      const V8 scale = hn::Set(d, prepared_.depth[n] * rows[j]);
      for (std::size_t i = 0; i < static_cast<std::size_t>(kWide); i += hn::Lanes(d)) {
        const V8 depth = hn::Mul(hn::LoadU(d, columns + i), scale);
        hn::Store(kIsThin ? opacityOfThin(d, depth) : opacityOf(d, depth), d, to + i);
      }
    }
    return to;
  }

  const VoxelView& view_;
  const ProjectedVoxels& projected_;
  const ShadedVoxels& shaded_;
  Prepared prepared_;
  std::uint32_t thin_ = 0;  // with a table: mask of the voxels that use opacityOfThin
  bool any_large_ = false;  // some footprint computes its weights row by row
  // Margin: a vector of pixels may begin before a footprint's row and end behind it.
  static constexpr std::size_t kBeside = kChunk;
  alignas(64) float weights_[kBeside + kVoxelBatch * kPacked * kPackedRows + kBeside];
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
