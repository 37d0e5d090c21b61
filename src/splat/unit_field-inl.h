// The values and gradients of a unit's samples, a vector of them at a time. Separable: planes of samples along z, rows
// of a plane along y, samples of a row along x. Values are known before gradients, which few samples need. Part of
// refine_unit.cpp, compiled once for each instruction set; hence no #pragma once.
#if defined(KILN_SPLAT_UNIT_FIELD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_SPLAT_UNIT_FIELD_INL_H
#undef KILN_SPLAT_UNIT_FIELD_INL_H
#else
#define KILN_SPLAT_UNIT_FIELD_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>

#include "splat/classify-inl.h"
#include "splat/lanes-inl.h"
#include "splat/refine_unit.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

// a + t (b - a), the end itself where t is 0: a voxel without weight may be NaN.
HWY_INLINE V mix(D d, V a, V b, V t) { return hn::IfThenElse(hn::Eq(t, hn::Zero(d)), a, between(a, b, t)); }

// The same where all lanes have one t.
HWY_INLINE V mix(D d, V a, V b, float t) { return t == 0 ? a : between(a, b, hn::Set(d, t)); }

// The central difference between a and b, at t of the way.
template <class T>
HWY_INLINE V slopeOf(D d, V before, V a, V b, V after, T t) {
  return hn::Mul(hn::Set(d, 0.5f), hn::Sub(mix(d, b, after, t), mix(d, before, a, t)));
}

// What fields of either kind are made of.
class UnitVoxels {
 protected:
  static constexpr int kEdge = kUnitVoxels + 2 * kUnitMargin;
  using Row = float[kUnitSamples];

  UnitVoxels(const UnitLattice& lattice, const UnitInput& unit)
      : l_(lattice),
        u_(unit),
        width_(static_cast<std::size_t>(lattice.voxels[0] + 2 * kUnitMargin)),
        height_(lattice.voxels[1] + 2 * kUnitMargin) {}

  const float* row(int y, int z) const { return u_.values + (z * height_ + y) * kUnitSamples; }

 public:
  // What a vector of voxels from (i, j, k) on stand for. requires: samples that are voxels.
  Interval interval(int i, int j, int k) const {
    const D d;
    const int y = j + kUnitMargin, z = k + kUnitMargin;
    const auto at = [&](int dx, int dy, int dz) { return hn::LoadU(d, row(y + dy, z + dz) + i + kUnitMargin + dx); };
    const V before[3] = {at(-1, 0, 0), at(0, -1, 0), at(0, 0, -1)};
    const V after[3] = {at(1, 0, 0), at(0, 1, 0), at(0, 0, 1)};
    return intervalOf(d, at(0, 0, 0), before, after);
  }

 protected:
  const UnitLattice& l_;
  const UnitInput& u_;
  const std::size_t width_;
  const int height_;
};

// Trilinear interpolation, of voxels and of their central differences.
class LinearField : public UnitVoxels {
 public:
  LinearField(const UnitLattice& lattice, const UnitInput& unit) : UnitVoxels(lattice, unit) {}

  // The plane of sample k along z: its values.
  void toPlane(int k) {
    const D d;
    const UnitAxis& axis = *u_.axis[2];
    k_ = static_cast<std::size_t>(k);
    rows_along_z_ = 0;
    const int z = axis.base[k_];
    const float t = axis.fraction[k_];
    for (int y = 0; y < height_; ++y) {
      for (std::size_t x = 0; x < width_; x += hn::Lanes(d))
        hn::Store(mix(d, hn::Load(d, row(y, z) + x), hn::Load(d, row(y, z + 1) + x), t), d, &value_[y][x]);
    }
  }

  // The row of sample j along y, in that plane.
  void toRow(int j) {
    const D d;
    j_ = static_cast<std::size_t>(j);
    derived_ = false;
    const UnitAxis& axis = *u_.axis[1];
    const int y = axis.base[j_];
    const float t = axis.fraction[j_];
    for (std::size_t x = 0; x < width_; x += hn::Lanes(d))
      hn::Store(mix(d, hn::Load(d, &value_[y][x]), hn::Load(d, &value_[y + 1][x]), t), d, &row_[x]);
  }

  // From sample i of that row on; `known` where no voxel with weight is NaN.
  V values(std::size_t i, M& known) const {
    const D d;
    const DI di;
    const UnitAxis& axis = *u_.axis[0];
    const VI base = hn::LoadU(di, &axis.base[i]);
    const VI next = hn::Add(base, hn::Set(di, 1));
    const V raw = mix(d, lookUp(d, row_, base), lookUp(d, row_, next), hn::LoadU(d, &axis.fraction[i]));
    known = hn::Eq(raw, raw);
    return hn::Min(hn::Max(raw, hn::Set(d, u_.least)), hn::Set(d, u_.most));
  }

  // unit: value per voxel.
  Vector gradients(std::size_t i) {
    if (!derived_) derive();
    const D d;
    const DI di;
    const UnitAxis& axis = *u_.axis[0];
    const VI base = hn::LoadU(di, &axis.base[i]);
    const V t = hn::LoadU(d, &axis.fraction[i]);
    const VI next = hn::Add(base, hn::Set(di, 1));
    const VI after = hn::Add(next, hn::Set(di, 1));
    const VI previous = hn::Sub(base, hn::Set(di, 1));
    const V along_x =
        slopeOf(d, lookUp(d, row_, previous), lookUp(d, row_, base), lookUp(d, row_, next), lookUp(d, row_, after), t);
    return {along_x, mix(d, lookUp(d, row_y_, base), lookUp(d, row_y_, next), t),
            mix(d, lookUp(d, row_z_, base), lookUp(d, row_z_, next), t)};
  }

 private:
  // Gradients along y and z of the row in turn.
  void derive() {
    const D d;
    derived_ = true;
    const UnitAxis& axis = *u_.axis[1];
    const int y = axis.base[j_];
    const float t = axis.fraction[j_];
    deriveAlongZ(y);
    deriveAlongZ(y + 1);
    for (std::size_t x = 0; x < width_; x += hn::Lanes(d)) {
      const V a = hn::Load(d, &value_[y][x]), b = hn::Load(d, &value_[y + 1][x]);
      const V before_a = hn::Load(d, &value_[y - 1][x]);
      const V after_b = hn::Load(d, &value_[y + 2][x]);
      hn::Store(slopeOf(d, before_a, a, b, after_b, t), d, &row_y_[x]);
      hn::Store(mix(d, hn::Load(d, &along_z_[y][x]), hn::Load(d, &along_z_[y + 1][x]), t), d, &row_z_[x]);
    }
  }

  // The central differences along z of row y of the plane.
  void deriveAlongZ(int y) {
    if ((rows_along_z_ >> y & 1) != 0) return;
    rows_along_z_ |= 1u << y;
    const D d;
    const UnitAxis& axis = *u_.axis[2];
    const int z = axis.base[k_];
    for (std::size_t x = 0; x < width_; x += hn::Lanes(d)) {
      const auto at = [&](int plane) { return hn::Load(d, row(y, plane) + x); };
      hn::Store(slopeOf(d, at(z - 1), at(z), at(z + 1), at(z + 2), axis.fraction[k_]), d, &along_z_[y][x]);
    }
  }

  std::size_t j_ = 0, k_ = 0;
  bool derived_ = false;
  unsigned rows_along_z_ = 0;  // those known
  alignas(64) Row value_[kEdge + 1], along_z_[kEdge + 1];
  alignas(64) Row row_, row_y_, row_z_;
};

// Either cubic; gradients are the B-spline's. A value is kept within the least and most of the 4³ voxels that it takes,
// all at once: kept axis by axis, ridges that run across a slope would be cut off, and it would matter which axis comes
// first. So what a cell, a unit or a brick holds bounds its samples exactly, the B-spline's with their rounding.
class CubicField : public UnitVoxels {
 public:
  CubicField(const UnitLattice& lattice, const UnitInput& unit)
      : CubicField(lattice, unit, lattice.interpolation != Interpolation::kCubic) {}
  CubicField(const UnitLattice& lattice, const UnitInput& unit, bool own_gradient)
      : UnitVoxels(lattice, unit), own_gradient_(own_gradient) {}

  void toPlane(int k) {
    const D d;
    const auto at = static_cast<std::size_t>(k);
    const UnitAxis& axis = *u_.axis[2];
    for (int y = 0; y < height_; ++y) {
      for (std::size_t x = 0; x < width_; x += hn::Lanes(d)) {
        const auto voxels = [&](int z) { return hn::Load(d, row(y, z) + x); };
        hn::Store(sum(axis.value, at, voxels), d, &value_[y][x]);
        hn::Store(least(axis.value, at, voxels), d, &least_[y][x]);
        hn::Store(most(axis.value, at, voxels), d, &most_[y][x]);
        hn::Store(sum(axis.slope, at, voxels), d, &along_z_[y][x]);
        if (own_gradient_) hn::Store(sum(axis.smooth, at, voxels), d, &smooth_[y][x]);
      }
    }
  }

  void toRow(int j) {
    const D d;
    j_ = static_cast<std::size_t>(j);
    derived_ = false;
    const CubicTaps& taps = u_.axis[1]->value;
    for (std::size_t x = 0; x < width_; x += hn::Lanes(d)) {
      hn::Store(sum(taps, j_, ColumnsOf{value_, x}), d, &row_[x]);
      hn::Store(least(taps, j_, ColumnsOf{least_, x}), d, &row_least_[x]);
      hn::Store(most(taps, j_, ColumnsOf{most_, x}), d, &row_most_[x]);
    }
  }

  V values(std::size_t i, M& known) const {
    const CubicTaps& taps = u_.axis[0]->value;
    const VI at[4] = {tap(taps, 0, i), tap(taps, 1, i), tap(taps, 2, i), tap(taps, 3, i)};
    const D d;
    const V raw = along(row_, taps, i);
    known = hn::Eq(raw, raw);
    const V lo = hn::Min(hn::Min(lookUp(d, row_least_, at[0]), lookUp(d, row_least_, at[1])),
                         hn::Min(lookUp(d, row_least_, at[2]), lookUp(d, row_least_, at[3])));
    const V hi = hn::Max(hn::Max(lookUp(d, row_most_, at[0]), lookUp(d, row_most_, at[1])),
                         hn::Max(lookUp(d, row_most_, at[2]), lookUp(d, row_most_, at[3])));
    return hn::Min(hn::Max(raw, lo), hi);
  }

  Vector gradients(std::size_t i) {
    if (!derived_) derive();
    const UnitAxis& axis = *u_.axis[0];
    return {along(own_gradient_ ? row_smooth_ : row_, axis.slope, i), along(row_y_, axis.smooth, i),
            along(row_z_, axis.smooth, i)};
  }

 private:
  // A vector of a plane's columns.
  struct ColumnsOf {
    const Row* plane;
    std::size_t x;
    V operator()(int y) const { return hn::Load(D(), &plane[y][x]); }
  };

  void derive() {
    const D d;
    derived_ = true;
    const UnitAxis& axis = *u_.axis[1];
    const Row* const plane = own_gradient_ ? smooth_ : value_;
    for (std::size_t x = 0; x < width_; x += hn::Lanes(d)) {
      hn::Store(sum(axis.slope, j_, ColumnsOf{plane, x}), d, &row_y_[x]);
      hn::Store(sum(axis.smooth, j_, ColumnsOf{along_z_, x}), d, &row_z_[x]);
      if (own_gradient_) hn::Store(sum(axis.smooth, j_, ColumnsOf{smooth_, x}), d, &row_smooth_[x]);
    }
  }

  // Of what `voxels` has at the taps of one sample. In pairs, see setTaps.
  template <class Voxels>
  static V sum(const CubicTaps& taps, std::size_t sample, const Voxels& voxels) {
    const D d;
    const auto term = [&](std::size_t n) {
      return hn::Mul(hn::Set(d, taps.weight[n][sample]), voxels(taps.at[n][sample]));
    };
    return hn::Add(hn::Add(term(0), term(1)), hn::Add(term(2), term(3)));
  }
  template <class Voxels>
  static V least(const CubicTaps& taps, std::size_t sample, const Voxels& voxels) {
    const auto term = [&](std::size_t n) { return voxels(taps.at[n][sample]); };
    return hn::Min(hn::Min(term(0), term(1)), hn::Min(term(2), term(3)));
  }
  template <class Voxels>
  static V most(const CubicTaps& taps, std::size_t sample, const Voxels& voxels) {
    const auto term = [&](std::size_t n) { return voxels(taps.at[n][sample]); };
    return hn::Max(hn::Max(term(0), term(1)), hn::Max(term(2), term(3)));
  }

  static VI tap(const CubicTaps& taps, std::size_t n, std::size_t i) { return hn::LoadU(DI(), &taps.at[n][i]); }

  // The same of a vector of samples of a row.
  static V along(const Row& row, const CubicTaps& taps, std::size_t i) {
    const D d;
    const auto term = [&](std::size_t n) {
      return hn::Mul(hn::LoadU(d, &taps.weight[n][i]), lookUp(d, row, tap(taps, n, i)));
    };
    return hn::Add(hn::Add(term(0), term(1)), hn::Add(term(2), term(3)));
  }

  const bool own_gradient_;  // not that of the values
  std::size_t j_ = 0;
  bool derived_ = false;
  alignas(64) Row value_[kEdge], least_[kEdge], most_[kEdge], smooth_[kEdge], along_z_[kEdge];
  alignas(64) Row row_, row_least_, row_most_, row_smooth_, row_y_, row_z_;
};

// Places that are known (splat/label_samples.h), with the B-spline's gradients of opacity. requires: axes of it.
class LabelField : public UnitVoxels {
 public:
  LabelField(const UnitLattice& lattice, const UnitInput& unit)
      : UnitVoxels(lattice, unit), opacities_(lattice, unit, false) {}

  void toPlane(int k) { k_ = k, plane_known_ = false; }
  void toRow(int j) { j_ = j, row_known_ = false; }

  V values(std::size_t i, M& known) const {
    const D d;
    known = hn::Eq(hn::Zero(d), hn::Zero(d));
    return hn::LoadU(d, u_.label_places + (k_ * kUnitSamples + j_) * kUnitSamples + i);
  }

  Vector gradients(std::size_t i) {
    if (!plane_known_) opacities_.toPlane(k_);
    if (!row_known_) opacities_.toRow(j_);
    plane_known_ = row_known_ = true;
    return opacities_.gradients(i);
  }

 private:
  CubicField opacities_;
  int j_ = 0, k_ = 0;
  bool plane_known_ = false, row_known_ = false;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
