// Values and gradients of the samples of a cell, interpolated from its voxels. A field has
// - interpolate(count): prepares the values of the first `count` samples of CellSamples::code;
// - values(n): the values of a vector of samples from the n-th on; NaN where a voxel with weight is NaN;
// - findSlopes(n, count), slopes(i): gradients of up to kLit samples of CellSamples::index from the n-th on, then a
//   vector of these gradients from the i-th on. unit: value per voxel.
// Compiled once for each instruction set; hence no #pragma once.
#if defined(KILN_SPLAT_CELL_FIELD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_SPLAT_CELL_FIELD_INL_H
#undef KILN_SPLAT_CELL_FIELD_INL_H
#else
#define KILN_SPLAT_CELL_FIELD_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "splat/cast_cell.h"
#include "splat/cubic_weights.h"
#include "splat/sample_math-inl.h"
#include "splat/unit_axis.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

using D2 = hn::CappedTag<float, 2>;
using D4 = hn::CappedTag<float, 4>;

// Trilinear interpolation of voxels, and of their central differences. kGaps: voxels may be NaN.
template <bool kGaps>
class LinearCellField {
 public:
  LinearCellField(const UnitLattice&, const CellInput& in, CellSamples& samples) : in_(in), s_(samples) {}

  // Stores the values before and after each sample along x.
  void interpolate(std::size_t count) {
    const D2 d;
    for (std::size_t n = 0; n < count; ++n) {
      const float* const at = in_.values + s_.offset[n];
      const auto y = hn::Set(d, s_.fraction[1][n]), z = hn::Set(d, s_.fraction[2][n]);
      for (std::size_t i = 0; i < 2; i += hn::Lanes(d)) {
        const auto row = [&](int dy, int dz) { return hn::LoadU(d, at + dz * kPlane + dy * kUnitSamples + i); };
        const auto near = mix(d, row(0, 0), row(1, 0), y), far = mix(d, row(0, 1), row(1, 1), y);
        hn::Store(mix(d, near, far, z), d, s_.pair + 2 * n + i);
      }
    }
  }

  HWY_INLINE V values(std::size_t n) const {
    const D d;
    V before, after;
    hn::LoadInterleaved2(d, s_.pair + 2 * n, before, after);
    return mix(d, before, after, hn::Load(d, s_.fraction[0] + n));
  }

  // Interpolates along y and z, four voxels along x at a time.
  HWY_INLINE void findSlopes(std::size_t n, std::size_t count) {
    const D4 d4;
    for (std::size_t lane = 0; lane < count; ++lane) {
      const auto index = static_cast<std::size_t>(s_.index[n + lane]);
      const float* const at = in_.values + s_.offset[index] - 1;
      s_.fraction_x[lane] = s_.fraction[0][index];
      const auto y = hn::Set(d4, s_.fraction[1][index]), z = hn::Set(d4, s_.fraction[2][index]);
      for (std::size_t i = 0; i < 4; i += hn::Lanes(d4)) {
        const auto row = [&](int dy, int dz) { return hn::LoadU(d4, at + dz * kPlane + dy * kUnitSamples + i); };
        const auto of_row = [&](int dy) { return mix(d4, row(dy, 0), row(dy, 1), z); };
        const auto along_z = [&](int dy) {
          return mix(d4, hn::Sub(row(dy, 1), row(dy, -1)), hn::Sub(row(dy, 2), row(dy, 0)), z);
        };
        const auto before = of_row(-1), here = of_row(0), next = of_row(1), after = of_row(2);
        hn::Store(mix(d4, here, next, y), d4, s_.rows[1] + 4 * lane + i);
        hn::Store(mix(d4, hn::Sub(next, before), hn::Sub(after, here), y), d4, s_.rows[2] + 4 * lane + i);
        hn::Store(mix(d4, along_z(0), along_z(1), y), d4, s_.rows[3] + 4 * lane + i);
      }
    }
  }

  // Interpolates along x.
  HWY_INLINE Vector slopes(std::size_t i) const {
    const D d;
    const V x = hn::Load(d, s_.fraction_x + i), half = hn::Set(d, 0.5f);
    V before, here, next, after, y_here, y_next, z_here, z_next, unused, other;
    hn::LoadInterleaved4(d, s_.rows[1] + 4 * i, before, here, next, after);
    hn::LoadInterleaved4(d, s_.rows[2] + 4 * i, unused, y_here, y_next, other);
    hn::LoadInterleaved4(d, s_.rows[3] + 4 * i, unused, z_here, z_next, other);
    return {hn::Mul(half, mix(d, hn::Sub(next, before), hn::Sub(after, here), x)),
            hn::Mul(half, mix(d, y_here, y_next, x)), hn::Mul(half, mix(d, z_here, z_next, x))};
  }

  // a + t (b - a); a itself where t is 0, because a voxel without weight may be NaN.
  template <class Tag, class Vec>
  static HWY_INLINE Vec mix(Tag d, Vec a, Vec b, Vec t) {
    const Vec out = between(a, b, t);
    if constexpr (kGaps) return hn::IfThenElse(hn::Eq(t, hn::Zero(d)), a, out);
    return out;
  }

 private:
  static constexpr int kPlane = CellInput::kPlane;
  const CellInput& in_;
  CellSamples& s_;
};

// The cubic B-spline or Catmull-Rom spline over 4³ voxels; gradients are the B-spline's. A value is clamped to the
// range of its 4³ voxels, so that the range of a cell bounds its samples.
class CubicCellField {
  using Weights = CubicWeights<float>;

 public:
  CubicCellField(const UnitLattice& lattice, const CellInput& in, CellSamples& samples)
      : in_(in), s_(samples), interpolation_(lattice.interpolation) {}

  void interpolate(std::size_t count) {
    const D4 d;
    for (std::size_t n = 0; n < count; ++n) {
      Weights w[3];
      for (std::size_t a = 0; a < 3; ++a) w[a] = valueWeights(s_.fraction[a][n]);
      const Taps y(w[1]), z(w[2]);
      alignas(16) float sum[4], least[4], most[4];
      for (std::size_t i = 0; i < 4; i += hn::Lanes(d)) {
        auto total = hn::Zero(d), lo = hn::Set(d, 3e38f), hi = hn::Set(d, -3e38f);
        forEachRow(n, y, z, i, [&](auto row, float weight) {
          total = hn::Add(total, hn::Mul(hn::Set(d, weight), row));
          lo = hn::Min(lo, row), hi = hn::Max(hi, row);
        });
        hn::Store(total, d, sum + i), hn::Store(lo, d, least + i), hn::Store(hi, d, most + i);
      }
      s_.pair[n] = clamped(w[0], sum, least, most);
    }
  }

  HWY_INLINE V values(std::size_t n) const { return hn::LoadU(D(), s_.pair + n); }

  void findSlopes(std::size_t n, std::size_t count) {
    for (std::size_t lane = 0; lane < count; ++lane) {
      const auto index = static_cast<std::size_t>(s_.index[n + lane]);
      Weights smooth[3], slope[3];
      for (std::size_t a = 0; a < 3; ++a)
        smooth[a] = bSplineWeights(s_.fraction[a][index]), slope[a] = bSplineSlopeWeights(s_.fraction[a][index]);
      s_.rows[1][lane] = sumOf(index, slope[0], smooth[1], smooth[2]);
      s_.rows[2][lane] = sumOf(index, smooth[0], slope[1], smooth[2]);
      s_.rows[3][lane] = sumOf(index, smooth[0], smooth[1], slope[2]);
    }
  }

  HWY_INLINE Vector slopes(std::size_t i) const {
    const D d;
    return {hn::LoadU(d, s_.rows[1] + i), hn::LoadU(d, s_.rows[2] + i), hn::LoadU(d, s_.rows[3] + i)};
  }

 private:
  static constexpr int kPlane = CellInput::kPlane;

  Weights valueWeights(float t) const {
    return interpolation_ == Interpolation::kCubic ? bSplineWeights(t) : catmullRomWeights(t);
  }

  // The taps of an axis that have weight: a voxel without weight may be NaN.
  struct Taps {
    explicit Taps(const Weights& weights) {
      for (int tap = 0; tap < 4; ++tap) {
        const float own = weights[static_cast<std::size_t>(tap)];
        if (own == 0) continue;
        at[count] = tap - 1, weight[count++] = own;
      }
    }
    int count = 0;
    int at[4];
    float weight[4];
  };

  // Calls f(voxels of a row from lane i of four on, weight of the row) for the rows around the n-th sample.
  template <class F>
  HWY_INLINE void forEachRow(std::size_t n, const Taps& y, const Taps& z, std::size_t i, F f) const {
    const float* const at = in_.values + s_.offset[n] - 1 + i;
    for (int k = 0; k < z.count; ++k) {
      for (int j = 0; j < y.count; ++j)
        f(hn::LoadU(D4(), at + z.at[k] * kPlane + y.at[j] * kUnitSamples), y.weight[j] * z.weight[k]);
    }
  }

  // The weighted sum of the rows' sums. Pairs are added first, so that equal voxels give their own value.
  static float along(const Weights& x, const float* sum) {
    const auto term = [&](std::size_t i) { return x[i] == 0 ? 0.0f : x[i] * sum[i]; };
    return (term(0) + term(1)) + (term(2) + term(3));
  }
  static float clamped(const Weights& x, const float* sum, const float* least, const float* most) {
    float lo = 3e38f, hi = -3e38f;
    for (std::size_t i = 0; i < 4; ++i) {
      if (x[i] != 0) lo = std::min(lo, least[i]), hi = std::max(hi, most[i]);
    }
    const float value = along(x, sum);
    return value != value ? value : std::min(std::max(value, lo), hi);
  }

  float sumOf(std::size_t n, const Weights& x, const Weights& y, const Weights& z) const {
    const D4 d;
    const Taps along_y(y), along_z(z);
    alignas(16) float sum[4];
    for (std::size_t i = 0; i < 4; i += hn::Lanes(d)) {
      auto total = hn::Zero(d);
      forEachRow(n, along_y, along_z, i,
                 [&](auto row, float weight) { total = hn::Add(total, hn::Mul(hn::Set(d, weight), row)); });
      hn::Store(total, d, sum + i);
    }
    return along(x, sum);
  }

  const CellInput& in_;
  CellSamples& s_;
  const Interpolation interpolation_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
