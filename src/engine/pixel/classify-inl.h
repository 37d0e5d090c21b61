// Classification of interpolated values, a vector at a time: table position, extinction, and mean extinction over the
// values that a sample of a coarser level stands for. README.md, equations (4) and (5). Compiled once for each
// instruction set; hence no #pragma once.
#if defined(KILN_CLASSIFY_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_CLASSIFY_INL_H
#undef KILN_CLASSIFY_INL_H
#else
#define KILN_CLASSIFY_INL_H
#endif

#include <hwy/highway.h>

#include "engine/pixel/voxels/sample_lattice.h"
#include "engine/shared/sample_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

// Table position of a value from which the table's offset has been subtracted.
HWY_INLINE V placeOf(D d, const SampleLattice& l, V value) {
  return hn::Min(hn::Max(hn::Mul(value, hn::Set(d, l.table_scale)), hn::Zero(d)), hn::Set(d, l.table_last));
}

HWY_INLINE V extinctionAt(D d, const SampleLattice& l, V place) {
  const VI entry = hn::ConvertTo(DI(), place);
  const V here = hn::GatherIndex(d, l.extinctions, entry), next = hn::GatherIndex(d, l.extinctions + 1, entry);
  return between(here, next, hn::Sub(place, hn::ConvertTo(d, entry)));
}

// Nodes around samples in the plane of values and gradient lengths.
struct PlanePlace {
  VI node;  // the node before the sample along both axes
  V x, y;   // position between nodes
};

// Row of a gradient; a gradient that is not finite counts as 0.
HWY_INLINE V planeRowOf(D d, const SampleLattice::Plane& p, const Vector& slope) {
  const M finite = hn::Lt(hn::Add(hn::Abs(slope.x), hn::Add(hn::Abs(slope.y), hn::Abs(slope.z))), hn::Set(d, 3e38f));
  const glm::mat3& m = p.rows_from_slope;
  const auto line = [&](int row) {
    return fused(hn::Set(d, m[0][row]), slope.x,
                 fused(hn::Set(d, m[1][row]), slope.y, hn::Mul(hn::Set(d, m[2][row]), slope.z)));
  };
  const V x = line(0), y = line(1), z = line(2);
  const V length = hn::IfThenElseZero(finite, hn::Sqrt(fused(x, x, fused(y, y, hn::Mul(z, z)))));
  return hn::Min(hn::Max(hn::Add(length, hn::Set(d, p.row_offset)), hn::Zero(d)), hn::Set(d, p.last_row));
}

// `entry`: table position of the value.
HWY_INLINE PlanePlace planePlaceOf(D d, const SampleLattice::Plane& p, V entry, V row) {
  const DI di;
  const V along = fused(entry, hn::Set(d, p.column_scale), hn::Set(d, p.column_offset));
  const V column = hn::Min(hn::Max(along, hn::Zero(d)), hn::Set(d, p.last_column));
  const VI x = hn::ConvertTo(di, column), y = hn::ConvertTo(di, row);
  return {hn::Add(x, hn::Mul(y, hn::Set(di, p.stride))), hn::Sub(column, hn::ConvertTo(d, x)),
          hn::Sub(row, hn::ConvertTo(d, y))};
}

HWY_INLINE V planeFactorAt(D d, const SampleLattice::Plane& p, const PlanePlace& at) {
  const auto along = [&](const float* row) {
    return between(hn::GatherIndex(d, row, at.node), hn::GatherIndex(d, row + 1, at.node), at.x);
  };
  return between(along(p.factors), along(p.factors + p.stride), at.y);
}

// Extinction of samples whose opacity per unit is multiplied by `factor`, never above `tau`.
HWY_INLINE V modulatedExtinction(D d, const SampleLattice::Plane& p, V tau, V factor) {
  constexpr float kOpaque = 0.9999f, kOpaqueDepth = 9.2103f;  // extinctionOf clamps opacities
  const V unit = hn::Set(d, p.unit), one = hn::Set(d, 1.0f);
  const V depth = hn::Mul(tau, unit);
  const V opacity = hn::IfThenElse(hn::Lt(depth, hn::Set(d, kOpaqueDepth)), opacityOf(d, depth), one);
  const V part = hn::Min(hn::Mul(factor, opacity), hn::Set(d, kOpaque));
  const V less = hn::Min(hn::Div(depthOf(d, part), unit), tau);
  return hn::IfThenElse(hn::Lt(factor, one), less, tau);
}

// Interval of values that a sample of a coarser level stands for.
// The interval extends `reach` above and below the sample's own value. `reach` is half a voxel times the gradient's
// length, so
// that intervals of adjacent voxels on a slope touch. The interval is limited to the values of the six neighbours at a
// distance of a voxel: the gradient alone would extend beyond the end of a slope, and find bone under every skin. unit:
// values.
struct Interval {
  V reach, least, most;
};

// Computes the interval from the sample's own value and the neighbours before and after it along each axis.
HWY_INLINE Interval intervalOf(D d, V own, const V (&before)[3], const V (&after)[3]) {
  V least = own, most = own, squared = hn::Zero(d);
  for (int a = 0; a < 3; ++a) {
    const V twice = hn::Sub(after[a], before[a]);
    squared = fused(twice, twice, squared);
    least = hn::Min(least, hn::Min(before[a], after[a]));
    most = hn::Max(most, hn::Max(before[a], after[a]));
  }
  return {hn::Mul(hn::Set(d, 0.25f), hn::Sqrt(squared)), least, most};
}

HWY_INLINE V integralTo(D d, const SampleLattice& l, V place) {
  const VI entry = hn::ConvertTo(DI(), place);
  const V a = hn::GatherIndex(d, l.integral, entry), b = hn::GatherIndex(d, l.integral + 1, entry);
  return between(a, b, hn::Sub(place, hn::ConvertTo(d, entry)));
}

// Mean extinction of the interval: the average of the mean above the sample's value and the mean below. A single mean
// over the interval would lose a thin skin between the values on its two sides. `place` is the value's table position,
// `at_point` its extinction. requires: l.integral. Source: Max, Hanrahan and Crawfis 1990; Engel et al. 2001. Equation
// (5).
HWY_INLINE V meanExtinction(D d, const SampleLattice& l, const Interval& values, V place, M alive, V at_point) {
  const V reach = hn::Mul(values.reach, hn::Set(d, l.table_scale));
  alive = hn::And(alive, hn::Lt(reach, hn::Set(d, 1e30f)));  // false for NaN, too
  const V own = hn::IfThenElseZero(alive, place);
  // A smoothed value may lie outside the interval of its neighbours.
  const V lo = hn::Min(own, hn::IfThenElseZero(alive, hn::Max(hn::Sub(place, reach), placeOf(d, l, values.least))));
  const V hi = hn::Max(own, hn::IfThenElseZero(alive, hn::Min(hn::Add(place, reach), placeOf(d, l, values.most))));
  const V to_own = integralTo(d, l, own);
  const auto mean = [&](V integral, V width) {
    const M wide = hn::Ge(width, hn::Set(d, l.least_interval));
    return hn::IfThenElse(wide, hn::Div(integral, hn::IfThenElse(wide, width, hn::Set(d, 1.0f))), at_point);
  };
  const V upper = mean(hn::Sub(integralTo(d, l, hi), to_own), hn::Sub(hi, own));
  const V lower = mean(hn::Sub(to_own, integralTo(d, l, lo)), hn::Sub(own, lo));
  return hn::Mul(hn::Set(d, 0.5f), hn::Add(upper, lower));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
