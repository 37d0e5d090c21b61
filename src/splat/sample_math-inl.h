// What kernels of all lattices compute of their samples, a vector of them at a time: exponentials, and the light of a
// headlight. Without fused or approximate operations: every instruction set gives the same bits. Compiled once for each
// instruction set; hence no #pragma once.
#if defined(KILN_SPLAT_SAMPLE_MATH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_SPLAT_SAMPLE_MATH_INL_H
#undef KILN_SPLAT_SAMPLE_MATH_INL_H
#else
#define KILN_SPLAT_SAMPLE_MATH_INL_H
#endif

#include <hwy/highway.h>

#include "splat/plain_light.h"

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

// 2^x = whole + whole · rest, `whole` a power of two, for -126 <= x <= 0; to 2e-6 of its value.
struct Power {
  V whole, rest;
};
HWY_INLINE Power powerOf(D d, V x) {
  const DI di;
  // Added, it leaves the nearest whole number in the last bits.
  const V rounder = hn::Set(d, 12582912.0f);  // 3 · 2^22
  const V rounded = hn::Add(x, rounder);
  const V f = hn::Sub(x, hn::Sub(rounded, rounder));
  V p = hn::Set(d, 0.00133336f);
  p = hn::Add(hn::Mul(p, f), hn::Set(d, 0.00961813f));
  p = hn::Add(hn::Mul(p, f), hn::Set(d, 0.05550411f));
  p = hn::Add(hn::Mul(p, f), hn::Set(d, 0.24022651f));
  p = hn::Add(hn::Mul(p, f), hn::Set(d, 0.69314718f));
  const VI exponent = hn::ShiftLeft<23>(hn::Add(hn::BitCast(di, rounded), hn::Set(di, 127)));
  return {hn::BitCast(d, exponent), hn::Mul(p, f)};
}

HWY_INLINE V exp2Of(D d, V x) {
  const Power p = powerOf(d, x);
  return hn::Add(p.whole, hn::Mul(p.whole, p.rest));
}

// log2 of 0 < x <= 1, to 2e-6.
HWY_INLINE V log2Of(D d, V x) {
  const DI di;
  const VI bits = hn::BitCast(di, x);
  // The mantissa in [sqrt(1/2), sqrt(2)).
  const VI e = hn::ShiftRight<23>(hn::Sub(bits, hn::Set(di, 0x3f3504f3)));
  const V m = hn::BitCast(d, hn::Sub(bits, hn::ShiftLeft<23>(e)));
  const V s = hn::Div(hn::Sub(m, hn::Set(d, 1.0f)), hn::Add(m, hn::Set(d, 1.0f)));
  const V s2 = hn::Mul(s, s);
  V p = hn::Set(d, 0.41219858f);
  p = hn::Add(hn::Mul(p, s2), hn::Set(d, 0.57707801f));
  p = hn::Add(hn::Mul(p, s2), hn::Set(d, 0.96179669f));
  p = hn::Add(hn::Mul(p, s2), hn::Set(d, 2.88539008f));
  return hn::Add(hn::ConvertTo(d, e), hn::Mul(s, p));
}

// 1 - exp(-x) for x >= 0. Where exp(-x) is nearer to one than to a half it is `rest` alone, so that thin media keep
// their digits.
HWY_INLINE V opacityOf(D d, V x) {
  const Power p = powerOf(d, hn::Max(hn::Mul(x, hn::Set(d, -1.44269504f)), hn::Set(d, -120.0f)));
  return hn::Sub(hn::Sub(hn::Set(d, 1.0f), p.whole), hn::Mul(p.whole, p.rest));
}

// Where samples are seen: across, over depth in perspective, and how long a ray is to there per depth.
struct Sight {
  V u, v, oblique;
};

// What a colour is multiplied by, and what is added to it, where the gradient says how it is lit; where it does not,
// `matte` and `gloss` stay.
HWY_INLINE void lightOn(D d, const PlainLight& light, bool perspective, const Vector& slope, const Sight& sight,
                        V& matte, V& gloss) {
  const V gx = slope.x, gy = slope.y, gz = slope.z;
  const auto squared = [](V a, V c, V e) { return hn::Add(hn::Mul(a, a), hn::Add(hn::Mul(c, c), hn::Mul(e, e))); };
  // False where it is NaN, too.
  const M lit = hn::And(hn::Gt(squared(gx, gy, gz), hn::Set(d, light.least_gradient_squared)),
                        hn::Lt(squared(gx, gy, gz), hn::Set(d, 1e38f)));
  const glm::mat3& m = light.view_from_index_gradient;
  const auto line = [&](int c) {
    return hn::Add(hn::Mul(hn::Set(d, m[0][c]), gx),
                   hn::Add(hn::Mul(hn::Set(d, m[1][c]), gy), hn::Mul(hn::Set(d, m[2][c]), gz)));
  };
  const V nx = line(0), ny = line(1), nz = line(2);
  V along = nz, length = hn::Sqrt(squared(nx, ny, nz));
  if (perspective) {
    along = hn::Add(nz, hn::Add(hn::Mul(sight.u, nx), hn::Mul(sight.v, ny)));
    length = hn::Mul(length, sight.oblique);
  }
  const V cosine = hn::Min(hn::Div(hn::Abs(along), length), hn::Set(d, 1.0f));
  matte = hn::IfThenElse(lit, hn::Add(hn::Set(d, light.ambient), hn::Mul(hn::Set(d, light.diffuse), cosine)), matte);
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
