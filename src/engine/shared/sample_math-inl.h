// Vector functions of samples for all engines: exponentials, logarithm, and the light of a headlight. No approximate
// operations, fused only where written: every instruction set returns equal bits. Compiled once for each instruction
// set; hence no #pragma once.
#if defined(KILN_SAMPLE_MATH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_SAMPLE_MATH_INL_H
#undef KILN_SAMPLE_MATH_INL_H
#else
#define KILN_SAMPLE_MATH_INL_H
#endif

#include <hwy/highway.h>

#include <cmath>

#include "engine/shared/fused.h"
#include "engine/shared/plain_light.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;
using M = hn::Mask<D>;

struct Vector {
  V x, y, z;
};

// Returns a b + c, rounded once like std::fma, also on processors without the instruction.
HWY_INLINE float fused(float a, float b, float c) {
#if HWY_NATIVE_FMA
  return std::fma(a, b, c);
#else
  return fusedInDoubles(a, b, c);
#endif
}
#if !HWY_NATIVE_FMA && HWY_TARGET != HWY_SCALAR
// a b + c of half a vector's floats in double precision, and a mask of sums halfway between two floats.
template <class DD>
struct SumsInDoubles {
  hn::Vec<DD> sum;
  hn::Mask<DD> halfway;
};
template <class DD, class Half>
HWY_INLINE SumsInDoubles<DD> sumsInDoubles(DD d, Half a, Half b, Half c) {
  const hn::RebindToUnsigned<DD> du;
  const auto sum = hn::Add(hn::Mul(hn::PromoteTo(d, a), hn::PromoteTo(d, b)), hn::PromoteTo(d, c));
  const auto gone = hn::And(hn::BitCast(du, sum), hn::Set(du, RoundedTwice::kGone));
  return {sum, hn::RebindMask(d, hn::Eq(gone, hn::Set(du, RoundedTwice::kHalf)))};
}
#endif
template <class Floats>
HWY_INLINE Floats fused(Floats a, Floats b, Floats c) {
#if HWY_NATIVE_FMA
  return hn::MulAdd(a, b, c);
#else
  const hn::DFromV<Floats> d;
#if HWY_TARGET != HWY_SCALAR
  // Vector form of fusedInDoubles; vectors with a case of double rounding take the scalar path below.
  const hn::Half<decltype(d)> half;
  const hn::Rebind<double, decltype(half)> dd;
  const auto lower = sumsInDoubles(dd, hn::LowerHalf(half, a), hn::LowerHalf(half, b), hn::LowerHalf(half, c));
  const auto upper = sumsInDoubles(dd, hn::UpperHalf(half, a), hn::UpperHalf(half, b), hn::UpperHalf(half, c));
  const auto small = hn::And(hn::Lt(hn::Abs(c), hn::Set(d, RoundedTwice::kLeastAddend)), hn::Ne(c, hn::Zero(d)));
  if (HWY_LIKELY(hn::AllFalse(dd, hn::Or(lower.halfway, upper.halfway)) && hn::AllFalse(d, small)))
    return hn::Combine(d, hn::DemoteTo(half, upper.sum), hn::DemoteTo(half, lower.sum));
#endif
  alignas(64) float of_a[hn::MaxLanes(d)], of_b[hn::MaxLanes(d)], of_c[hn::MaxLanes(d)];
  hn::Store(a, d, of_a), hn::Store(b, d, of_b), hn::Store(c, d, of_c);
  for (std::size_t i = 0; i < hn::Lanes(d); ++i) of_c[i] = fusedInDoubles(of_a[i], of_b[i], of_c[i]);
  return hn::Load(d, of_c);
#endif
}
// Returns c - a b, rounded once. Negating `a` is exact.
template <class Floats>
HWY_INLINE Floats fusedLess(Floats a, Floats b, Floats c) {
#if HWY_NATIVE_FMA
  return hn::NegMulAdd(a, b, c);
#else
  return fused(hn::Neg(a), b, c);
#endif
}

// Linear interpolation from a (t = 0) to b (t = 1).
template <class Floats>
HWY_INLINE Floats between(Floats a, Floats b, Floats t) {
  return fused(t, hn::Sub(b, a), a);
}

HWY_INLINE V dotOf(const Vector& a, const Vector& b) { return fused(a.x, b.x, fused(a.y, b.y, hn::Mul(a.z, b.z))); }
HWY_INLINE Vector vectorOf(const glm::vec3& v) {
  const D d;
  return {hn::Set(d, v.x), hn::Set(d, v.y), hn::Set(d, v.z)};
}

// 2^x = whole + whole · rest for -126 <= x <= 0, `whole` a power of two. Relative error 2e-6.
template <class DF>
struct Power {
  hn::Vec<DF> whole, rest;
};
template <class DF>
HWY_INLINE Power<DF> powerOf(DF d, hn::Vec<DF> x) {
  using F = hn::Vec<DF>;
  const hn::RebindToSigned<DF> di;
  // Adding 3 · 2^22 leaves the nearest integer in the last bits.
  const F rounder = hn::Set(d, 12582912.0f);  // 3 · 2^22
  const F rounded = hn::Add(x, rounder);
  const F f = hn::Sub(x, hn::Sub(rounded, rounder));
  F p = hn::Set(d, 0.00133336f);
  p = fused(p, f, hn::Set(d, 0.00961813f));
  p = fused(p, f, hn::Set(d, 0.05550411f));
  p = fused(p, f, hn::Set(d, 0.24022651f));
  p = fused(p, f, hn::Set(d, 0.69314718f));
  const auto exponent = hn::ShiftLeft<23>(hn::Add(hn::BitCast(di, rounded), hn::Set(di, 127)));
  return {hn::BitCast(d, exponent), hn::Mul(p, f)};
}

template <class DF>
HWY_INLINE hn::Vec<DF> exp2Of(DF d, hn::Vec<DF> x) {
  const Power<DF> p = powerOf(d, x);
  return fused(p.whole, p.rest, p.whole);
}

// log2(x) for 0 < x <= 1. Error 2e-6.
HWY_INLINE V log2Of(D d, V x) {
  const DI di;
  const VI bits = hn::BitCast(di, x);
  // Split off the exponent so that the mantissa is in [sqrt(1/2), sqrt(2)).
  const VI e = hn::ShiftRight<23>(hn::Sub(bits, hn::Set(di, 0x3f3504f3)));
  const V m = hn::BitCast(d, hn::Sub(bits, hn::ShiftLeft<23>(e)));
  const V s = hn::Div(hn::Sub(m, hn::Set(d, 1.0f)), hn::Add(m, hn::Set(d, 1.0f)));
  const V s2 = hn::Mul(s, s);
  V p = hn::Set(d, 0.41219858f);
  p = fused(p, s2, hn::Set(d, 0.57707801f));
  p = fused(p, s2, hn::Set(d, 0.96179669f));
  p = fused(p, s2, hn::Set(d, 2.88539008f));
  return fused(s, p, hn::ConvertTo(d, e));
}

// 1 - exp(-x) for x >= 0. If exp(-x) is nearer to 1 than to 1/2, the result is `rest` alone, so that thin media keep
// their precision.
template <class DF>
HWY_INLINE hn::Vec<DF> opacityOf(DF d, hn::Vec<DF> x) {
  const Power<DF> p = powerOf(d, hn::Max(hn::Mul(x, hn::Set(d, -1.44269504f)), hn::Set(d, -120.0f)));
  return fusedLess(p.whole, p.rest, hn::Sub(hn::Set(d, 1.0f), p.whole));
}

// -ln(1 - x) for 0 <= x < 1: the inverse of opacityOf, as precise for thin media. Relative error 3e-6.
HWY_INLINE V depthOf(D d, V x) {
  const V one = hn::Set(d, 1.0f);
  const V s = hn::Div(x, hn::Sub(hn::Set(d, 2.0f), x)), s2 = hn::Mul(s, s);
  // 2 artanh(s), for x <= 1/4.
  V p = hn::Set(d, 2.0f / 7);
  p = fused(p, s2, hn::Set(d, 2.0f / 5));
  p = fused(p, s2, hn::Set(d, 2.0f / 3));
  p = fused(p, s2, hn::Set(d, 2.0f));
  const V thick = hn::Mul(log2Of(d, hn::Sub(one, x)), hn::Set(d, -0.69314718f));
  return hn::IfThenElse(hn::Lt(x, hn::Set(d, 0.25f)), hn::Mul(s, p), thick);
}

// 1 - exp(-x) for 0 <= x <= kThin, with half the operations of opacityOf. Relative error 1e-6.
constexpr float kThin = 0.35f;
template <class DF>
HWY_INLINE hn::Vec<DF> opacityOfThin(DF d, hn::Vec<DF> x) {
  hn::Vec<DF> p = hn::Set(d, -1.0f / 720);
  p = fused(p, x, hn::Set(d, 1.0f / 120));
  p = fused(p, x, hn::Set(d, -1.0f / 24));
  p = fused(p, x, hn::Set(d, 1.0f / 6));
  p = fused(p, x, hn::Set(d, -0.5f));
  p = fused(p, x, hn::Set(d, 1.0f));
  return hn::Mul(x, p);
}

// View direction of samples: u = x/z, v = y/z, and oblique = 1 / cos θ, the length of a ray per unit of depth.
// Orthographic: 0, 0, 1.
struct Sight {
  V u, v, oblique;
};

// Phong light of a headlight: colour · matte + gloss. Samples whose gradient has no direction keep their `matte` and
// `gloss`. Source: Blinn 1977.
HWY_INLINE void lightOn(D d, const PlainLight& light, bool perspective, const Vector& slope, const Sight& sight,
                        V& matte, V& gloss) {
  const V factor = hn::Set(d, light.gradient.factor);
  const V gx = hn::Mul(slope.x, factor), gy = hn::Mul(slope.y, factor), gz = hn::Mul(slope.z, factor);
  const auto squared = [](V a, V c, V e) { return fused(a, a, fused(c, c, hn::Mul(e, e))); };
  // False for NaN, too.
  const M lit = hn::And(hn::Gt(squared(gx, gy, gz), hn::Set(d, light.gradient.least_squared)),
                        hn::Lt(squared(gx, gy, gz), hn::Set(d, 1e38f)));
  const glm::mat3& m = light.view_from_index_gradient;
  const auto line = [&](int c) {
    return fused(hn::Set(d, m[0][c]), gx, fused(hn::Set(d, m[1][c]), gy, hn::Mul(hn::Set(d, m[2][c]), gz)));
  };
  const V nx = line(0), ny = line(1), nz = line(2);
  V along = nz, length = hn::Sqrt(squared(nx, ny, nz));
  if (perspective) {
    along = fused(sight.u, nx, fused(sight.v, ny, nz));
    length = hn::Mul(length, sight.oblique);
  }
  const V cosine = hn::Min(hn::Div(hn::Abs(along), length), hn::Set(d, 1.0f));
  matte = hn::IfThenElse(lit, fused(hn::Set(d, light.diffuse), cosine, hn::Set(d, light.ambient)), matte);
  if (light.specular > 0) {
    const V log = hn::Mul(log2Of(d, hn::Max(cosine, hn::Set(d, 1e-30f))), hn::Set(d, light.power));
    const V power = exp2Of(d, hn::Min(hn::Max(log, hn::Set(d, -120.0f)), hn::Zero(d)));
    gloss = hn::IfThenElse(lit, hn::Mul(hn::Set(d, light.specular), power), gloss);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
