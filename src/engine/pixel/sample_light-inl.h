// Light of a vector of samples in any lights, with shadows and ambient occlusion: the form of Shader for kernels. No
// approximate operations, fused only where written. Compiled once for each instruction set; hence no #pragma once.
#if defined(KILN_SAMPLE_LIGHT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_SAMPLE_LIGHT_INL_H
#undef KILN_SAMPLE_LIGHT_INL_H
#else
#define KILN_SAMPLE_LIGHT_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "engine/shared/sample_math-inl.h"
#include "engine/shared/shade.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

HWY_INLINE V dotOf(const Vector& a, const Vector& b) { return fused(a.x, b.x, fused(a.y, b.y, hn::Mul(a.z, b.z))); }
HWY_INLINE Vector scaled(const Vector& a, V by) { return {hn::Mul(a.x, by), hn::Mul(a.y, by), hn::Mul(a.z, by)}; }
HWY_INLINE Vector vectorOf(const glm::vec3& v) {
  const D d;
  return {hn::Set(d, v.x), hn::Set(d, v.y), hn::Set(d, v.z)};
}
HWY_INLINE Vector unitOf(const Vector& a) {
  const D d;
  return scaled(a, hn::Div(hn::Set(d, 1.0f), hn::Sqrt(dotOf(a, a))));
}
HWY_INLINE Vector turnedBy(const glm::mat3& m, const Vector& a) {
  const D d;
  const auto line = [&](int row) {
    return fused(hn::Set(d, m[0][row]), a.x, fused(hn::Set(d, m[1][row]), a.y, hn::Mul(hn::Set(d, m[2][row]), a.z)));
  };
  return {line(0), line(1), line(2)};
}

// x^power for 0 <= x <= 1.
HWY_INLINE V powerOf(D d, V x, float power) {
  const V log = hn::Mul(log2Of(d, hn::Max(x, hn::Set(d, 1e-30f))), hn::Set(d, power));
  return exp2Of(d, hn::Min(hn::Max(log, hn::Set(d, -120.0f)), hn::Zero(d)));
}

struct Colors {
  V red, green, blue;
};

// Lights samples of a level. `M` is a mask of lanes.
class SampleLight {
 public:
  SampleLight(const Shader& shader, bool perspective) : s_(shader.model()), perspective_(perspective) {}

  // Lights the colours of samples at view-space positions; `alive`: lanes that hold samples.
  HWY_INLINE void on(const Vector& slope, const Sight& sight, const Vector& at, M alive, Colors& colors) const {
    const D d;
    const V one = hn::Set(d, 1.0f), zero = hn::Zero(d);
    const Vector gradient = scaled(slope, hn::Set(d, s_.gradient.factor));
    const V squared = dotOf(gradient, gradient);
    // False for NaN, too.
    const M directed =
        hn::And(hn::Gt(squared, hn::Set(d, s_.gradient.least_squared)), hn::Lt(squared, hn::Set(d, 1e38f)));
    Vector to_eye{zero, zero, hn::Set(d, -1.0f)};
    if (perspective_) to_eye = scaled(Vector{sight.u, sight.v, one}, hn::Div(hn::Set(d, -1.0f), sight.oblique));
    Vector normal = turnedBy(s_.view_from_index_gradient, gradient);
    const V length = hn::Sqrt(dotOf(normal, normal));
    const V inverse = hn::IfThenElseZero(directed, hn::Div(one, hn::IfThenElse(directed, length, one)));
    const V facing = hn::Mul(dotOf(normal, to_eye), inverse);
    normal = scaled(normal, hn::Or(inverse, hn::And(facing, hn::SignBit(d))));
    for (V* axis : {&normal.x, &normal.y, &normal.z}) *axis = hn::IfThenElseZero(directed, *axis);
    const V cosine = hn::Min(hn::Abs(facing), one);

    const V open = s_.occlusion.none() ? one : openOf(at, normal);
    const V ambient = hn::Mul(hn::Set(d, s_.ambient), open);
    const V diffuse = s_.occludes_diffuse ? hn::Mul(hn::Set(d, s_.diffuse), open) : hn::Set(d, s_.diffuse);
    const V gloss_of_eye =
        s_.specular > 0 && s_.has_headlight ? hn::Mul(hn::Set(d, s_.specular), powerOf(d, cosine, s_.power)) : zero;
    V matte[3], gloss[3], all[3], reaching[3];
    for (int c = 0; c < 3; ++c) {
      const V headlight = hn::Set(d, s_.headlight[c]);
      matte[c] = fused(hn::Mul(diffuse, cosine), headlight, ambient);
      gloss[c] = hn::Mul(gloss_of_eye, headlight);
      all[c] = reaching[c] = headlight;
    }
    for (const Shader::PlacedLight& light : s_.lights) {
      Vector towards = vectorOf(light.place);
      if (light.point) towards = unitOf({hn::Sub(towards.x, at.x), hn::Sub(towards.y, at.y), hn::Sub(towards.z, at.z)});
      const V lit = hn::Max(dotOf(normal, towards), zero);
      // Samples without direction need shadows from everywhere.
      const M needed = s_.shadowed ? hn::And(alive, hn::Or(hn::Not(directed), hn::Gt(lit, zero)))
                                   : hn::And(alive, hn::Gt(lit, zero));
      if (hn::AllFalse(d, needed)) continue;
      const V share =
          light.shadow.none() ? one : shareOf(light.shadow, at, towards, hn::IfThenElse(directed, lit, one), needed);
      const V of_matte = hn::Mul(hn::Mul(diffuse, lit), share);
      V of_gloss = zero;
      if (s_.specular > 0) {
        const Vector halfway =
            unitOf({hn::Add(towards.x, to_eye.x), hn::Add(towards.y, to_eye.y), hn::Add(towards.z, to_eye.z)});
        const V mirrored = hn::Min(hn::Max(dotOf(normal, halfway), zero), one);
        of_gloss = hn::Mul(hn::Mul(hn::Set(d, s_.specular), powerOf(d, mirrored, s_.power)), share);
        of_gloss = hn::IfThenElseZero(hn::Gt(lit, zero), of_gloss);
      }
      for (int c = 0; c < 3; ++c) {
        const V color = hn::Set(d, light.color[c]);
        matte[c] = fused(of_matte, color, matte[c]);
        gloss[c] = fused(of_gloss, color, gloss[c]);
        all[c] = hn::Add(all[c], color);
        reaching[c] = fused(share, color, reaching[c]);
      }
    }
    V* const out[3] = {&colors.red, &colors.green, &colors.blue};
    for (int c = 0; c < 3; ++c) {
      V flat = *out[c];
      if (s_.dims_flat) flat = hn::Mul(flat, flatShare(open, all[c], reaching[c]));
      *out[c] = hn::IfThenElse(directed, fused(*out[c], matte[c], gloss[c]), flat);
    }
  }

 private:
  // Share of its colour that a sample without direction keeps: see Shader::withoutDirection.
  HWY_INLINE V flatShare(V open, V all, V reaching) const {
    const D d;
    const V one = hn::Set(d, 1.0f), zero = hn::Zero(d);
    const M any = hn::Gt(all, zero);
    const V kept = hn::IfThenElse(any, hn::Div(reaching, hn::IfThenElse(any, all, one)), one);
    const V diffuse = s_.occludes_diffuse ? hn::Mul(kept, open) : kept;
    return hn::Mul(fused(hn::Set(d, s_.ambient), open, hn::Mul(hn::Set(d, s_.diffuse), diffuse)),
                   hn::Set(d, 1 / (s_.ambient + s_.diffuse)));
  }

  HWY_NOINLINE V shareOf(const ShadowLookup& shadow, const Vector& at, const Vector& towards, V cosine,
                         M needed) const {
    const D d;
    constexpr std::size_t kLanes = hn::MaxLanes(D());
    alignas(64) float x[kLanes], y[kLanes], z[kLanes], share[kLanes];
    const V start = hn::Div(hn::Set(d, shadow.start()), hn::Max(cosine, hn::Set(d, ShadowLookup::kLeastCosine)));
    hn::Store(fused(start, towards.x, at.x), d, x);
    hn::Store(fused(start, towards.y, at.y), d, y);
    hn::Store(fused(start, towards.z, at.z), d, z);
    hn::Store(hn::IfThenElseZero(needed, hn::Set(d, 1.0f)), d, share);
    for (std::size_t i = 0; i < hn::Lanes(d); ++i) {
      if (share[i] != 0) share[i] = shadow.share({x[i], y[i], z[i]});
    }
    return hn::Load(d, share);
  }

  // Share of ambient light: the vector form of AmbientLookup.
  HWY_NOINLINE V openOf(const Vector& at, const Vector& normal) const {
    const D d;
    const DI di;
    const AmbientLookup& ambient = s_.occlusion;
    const Vector turned = turnedBy(ambient.turned(), normal);
    const glm::mat4& m = ambient.gridFromView();
    const Vector moved = turnedBy(glm::mat3(m), at);
    const Extent3& n = ambient.grid().dims();
    const V along[3] = {turned.x, turned.y, turned.z}, place[3] = {moved.x, moved.y, moved.z};
    VI cell[3];
    V part[3];
    for (int axis = 0; axis < 3; ++axis) {
      const V p = hn::Add(hn::Add(place[axis], hn::Set(d, m[3][axis])), along[axis]);
      const V inside = hn::Min(hn::Max(p, hn::Zero(d)), hn::Set(d, static_cast<float>(n[axis] - 1)));
      cell[axis] = hn::Min(hn::ConvertTo(di, inside), hn::Set(di, static_cast<std::int32_t>(n[axis]) - 2));
      part[axis] = hn::Sub(inside, hn::ConvertTo(d, cell[axis]));
    }
    const auto width = static_cast<std::int32_t>(n.x), plane = static_cast<std::int32_t>(n.x * n.y);
    const VI first =
        hn::Add(cell[0], hn::Add(hn::Mul(cell[1], hn::Set(di, width)), hn::Mul(cell[2], hn::Set(di, plane))));
    const auto* const cells = reinterpret_cast<const std::int32_t*>(ambient.grid().cells());
    V mean = hn::Zero(d), turned_mean = hn::Zero(d);
    for (int corner = 0; corner < 8; ++corner) {
      const std::int32_t beside = (corner & 1) + (corner >> 1 & 1) * width + (corner >> 2) * plane;
      const VI word = hn::GatherIndex(di, cells, hn::Add(first, hn::Set(di, beside)));
      const V one = hn::Set(d, 1.0f);
      V weight = (corner & 1) != 0 ? part[0] : hn::Sub(one, part[0]);
      weight = hn::Mul(weight, (corner & 2) != 0 ? part[1] : hn::Sub(one, part[1]));
      weight = hn::Mul(weight, (corner & 4) != 0 ? part[2] : hn::Sub(one, part[2]));
      // The cell's bytes, from the lowest: mean, x, y, z.
      const V m0 = hn::ConvertTo(d, hn::And(word, hn::Set(di, 255)));
      const V mx = hn::ConvertTo(d, hn::ShiftRight<24>(hn::ShiftLeft<16>(word)));
      const V my = hn::ConvertTo(d, hn::ShiftRight<24>(hn::ShiftLeft<8>(word)));
      const V mz = hn::ConvertTo(d, hn::ShiftRight<24>(word));
      mean = fused(weight, m0, mean);
      turned_mean = fused(weight, dotOf({mx, my, mz}, turned), turned_mean);
    }
    const V seen =
        fused(turned_mean, hn::Set(d, 2 * AmbientCell::kAlong), hn::Mul(mean, hn::Set(d, AmbientCell::kMean)));
    const V shut = hn::Sub(hn::Set(d, 1.0f), hn::Min(hn::Max(seen, hn::Zero(d)), hn::Set(d, 1.0f)));
    return fusedLess(hn::Set(d, ambient.strength()), shut, hn::Set(d, 1.0f));
  }

  const Shader::Model& s_;
  const bool perspective_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
