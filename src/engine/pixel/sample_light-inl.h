// Light of a vector of samples in any lights, with shadows and ambient occlusion: the form of Shader for kernels. No
// approximate operations, fused only where written. Compiled once for each instruction set; hence no #pragma once.
#if defined(KILN_SAMPLE_LIGHT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_SAMPLE_LIGHT_INL_H
#undef KILN_SAMPLE_LIGHT_INL_H
#else
#define KILN_SAMPLE_LIGHT_INL_H
#endif

#include <hwy/highway.h>

#include <bit>
#include <cstddef>
#include <cstdint>

#include "engine/pixel/ambient_cells-inl.h"
#include "engine/shared/sample_math-inl.h"
#include "engine/shared/shade.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

HWY_INLINE Vector scaled(const Vector& a, V by) { return {hn::Mul(a.x, by), hn::Mul(a.y, by), hn::Mul(a.z, by)}; }
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

  // Lights the colours of samples at view-space positions. `on_face`: slopes are normals of the volume's faces;
  // `alive`: lanes that hold samples.
  HWY_INLINE void on(const Vector& slope, M on_face, const Sight& sight, const Vector& at, M alive,
                     Colors& colors) const {
    if (s_.scatters) return scatter(sight, at, alive, colors);
    const D d;
    const V one = hn::Set(d, 1.0f), zero = hn::Zero(d);
    const Vector gradient = scaled(slope, hn::Set(d, s_.gradient.factor));
    const V squared = dotOf(gradient, gradient);
    // False for NaN, too.
    const M directed =
        hn::And(hn::Gt(squared, hn::Set(d, s_.gradient.least_squared)), hn::Lt(squared, hn::Set(d, 1e38f)));
    const Vector to_eye = toEye(sight);
    Vector normal = turnedBy(s_.view_from_index_gradient, gradient);
    const V length = hn::Sqrt(dotOf(normal, normal));
    const V inverse = hn::IfThenElseZero(directed, hn::Div(one, hn::IfThenElse(directed, length, one)));
    const V facing = hn::Mul(dotOf(normal, to_eye), inverse);
    normal = scaled(normal, hn::Or(inverse, hn::And(facing, hn::SignBit(d))));
    for (V* axis : {&normal.x, &normal.y, &normal.z}) *axis = hn::IfThenElseZero(directed, *axis);
    const M behind = hn::And(hn::AndNot(on_face, directed),
                             hn::And(hn::Lt(facing, zero), hn::Gt(facing, hn::Set(d, s_.grazing.reversed))));
    if (!hn::AllFalse(d, behind)) normal = atSilhouette(normal, facing, to_eye, behind);
    const V cosine = hn::Min(hn::Abs(facing), one);

    const V open = s_.occlusion.none() ? one : openOf(at, normal);
    const V ambient = hn::Mul(hn::Set(d, s_.ambient), open);
    const V diffuse = s_.occludes_diffuse ? hn::Mul(hn::Set(d, s_.diffuse), open) : hn::Set(d, s_.diffuse);
    const V gloss_of_eye =
        s_.specular > 0 && s_.has_headlight ? hn::Mul(hn::Set(d, s_.specular), powerOf(d, cosine, s_.power)) : zero;
    // All channels of grey light are equal.
    const int channels = s_.grey ? 1 : 3;
    V matte[3], gloss[3], all[3], reaching[3];
    for (int c = 0; c < channels; ++c) {
      const V headlight = hn::Set(d, s_.headlight[c]);
      matte[c] = fused(hn::Mul(diffuse, cosine), headlight, ambient);
      gloss[c] = hn::Mul(gloss_of_eye, headlight);
      all[c] = reaching[c] = headlight;
    }
    for (const Shader::PlacedLight& light : s_.lights) {
      const Vector towards = towardsOf(light, at);
      const V lit = hn::Max(dotOf(normal, towards), zero);
      // Samples without direction need shadows from everywhere.
      const M needed = s_.shadowed ? hn::And(alive, hn::Or(hn::Not(directed), hn::Gt(lit, zero)))
                                   : hn::And(alive, hn::Gt(lit, zero));
      if (hn::AllFalse(d, needed)) continue;
      const V share = light.shadow.none() ? one : shareOf(light.shadow, at, normal, towards, lit, needed);
      const V of_matte = hn::Mul(hn::Mul(diffuse, lit), share);
      V of_gloss = zero;
      if (s_.specular > 0) {
        const Vector halfway =
            unitOf({hn::Add(towards.x, to_eye.x), hn::Add(towards.y, to_eye.y), hn::Add(towards.z, to_eye.z)});
        const V mirrored = hn::Min(hn::Max(dotOf(normal, halfway), zero), one);
        of_gloss = hn::Mul(hn::Mul(hn::Set(d, s_.specular), powerOf(d, mirrored, s_.power)), share);
        of_gloss = hn::IfThenElseZero(hn::Gt(lit, zero), of_gloss);
      }
      for (int c = 0; c < channels; ++c) {
        const V color = hn::Set(d, light.color[c]);
        matte[c] = fused(of_matte, color, matte[c]);
        gloss[c] = fused(of_gloss, color, gloss[c]);
        all[c] = hn::Add(all[c], color);
        reaching[c] = fused(share, color, reaching[c]);
      }
    }
    const bool dims = s_.dims_flat && !hn::AllFalse(d, hn::AndNot(directed, alive));
    V* const out[3] = {&colors.red, &colors.green, &colors.blue};
    for (int c = 0; c < 3; ++c) {
      const int of = c % channels;
      V flat = *out[c];
      if (dims) flat = hn::Mul(flat, flatShare(open, all[of], reaching[of]));
      *out[c] = hn::IfThenElse(directed, fused(*out[c], matte[of], gloss[of]), flat);
    }
  }

 private:
  // The vector form of seenNormal, of normals that were reversed: a sum of the normal and the direction to the eye,
  // whose length follows from `facing`.
  HWY_INLINE Vector atSilhouette(const Vector& reversed, V facing, const Vector& to_eye, M behind) const {
    const D d;
    const V one = hn::Set(d, 1.0f), squared = hn::Mul(facing, facing);
    const V turning = fused(hn::Set(d, s_.grazing.slope), facing, hn::Set(d, s_.grazing.offset));
    const V across = hn::Min(turning, one);
    const V length = hn::Sqrt(fused(hn::Mul(across, across), hn::Sub(one, squared), squared));
    const V scale = hn::Div(hn::Set(d, -1.0f), length);
    const V of_normal = hn::IfThenElse(behind, hn::Mul(across, scale), one);
    const V of_eye = hn::IfThenElseZero(behind, hn::Mul(hn::Mul(hn::Add(across, one), facing), scale));
    const auto sum = [&](V normal, V eye) { return fused(of_eye, eye, hn::Mul(of_normal, normal)); };
    return {sum(reversed.x, to_eye.x), sum(reversed.y, to_eye.y), sum(reversed.z, to_eye.z)};
  }

  HWY_INLINE Vector toEye(const Sight& sight) const {
    const D d;
    if (!perspective_) return {hn::Zero(d), hn::Zero(d), hn::Set(d, -1.0f)};
    return scaled(Vector{sight.u, sight.v, hn::Set(d, 1.0f)}, hn::Div(hn::Set(d, -1.0f), sight.oblique));
  }

  HWY_INLINE V phaseOf(V cosine) const {
    const D d;
    const V base = fusedLess(hn::Set(d, s_.phase.twice), cosine, hn::Set(d, s_.phase.squared));
    return hn::Div(hn::Set(d, s_.phase.numerator), hn::Mul(base, hn::Sqrt(base)));
  }

  // Light that a medium scatters towards the eye: Shader::scattered.
  HWY_NOINLINE void scatter(const Sight& sight, const Vector& at, M alive, Colors& colors) const {
    const D d;
    const V one = hn::Set(d, 1.0f), zero = hn::Zero(d), diffuse = hn::Set(d, s_.diffuse);
    const Vector to_eye = toEye(sight);
    const V open = s_.occlusion.none() ? one : openOf(at, {zero, zero, zero});
    const V back = hn::Mul(diffuse, phaseOf(hn::Set(d, -1.0f)));
    V sum[3];
    for (int c = 0; c < 3; ++c)
      sum[c] = fused(back, hn::Set(d, s_.headlight[c]), hn::Mul(hn::Set(d, s_.ambient), open));
    for (const Shader::PlacedLight& light : s_.lights) {
      const Vector towards = towardsOf(light, at);
      V reaching = hn::Mul(diffuse, phaseOf(hn::Neg(dotOf(towards, to_eye))));
      if (!light.shadow.none()) reaching = hn::Mul(reaching, shareAt(light.shadow, at, alive));
      for (int c = 0; c < 3; ++c) sum[c] = fused(reaching, hn::Set(d, light.color[c]), sum[c]);
    }
    colors.red = hn::Mul(colors.red, sum[0]);
    colors.green = hn::Mul(colors.green, sum[1]);
    colors.blue = hn::Mul(colors.blue, sum[2]);
  }

  // Shader::PlacedLight::towards.
  static HWY_INLINE Vector towardsOf(const Shader::PlacedLight& light, const Vector& at) {
    const Vector place = vectorOf(light.place);
    if (!light.point) return place;
    const Vector way = {hn::Sub(place.x, at.x), hn::Sub(place.y, at.y), hn::Sub(place.z, at.z)}, unit = unitOf(way);
    const D d;
    const M apart = hn::Gt(dotOf(way, way), hn::Zero(d));
    return {hn::IfThenElseZero(apart, unit.x), hn::IfThenElseZero(apart, unit.y), hn::IfThenElseZero(apart, unit.z)};
  }

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

  // The vector form of ShadowLookup's operator. `cosine`: of the angle between the normal and the light.
  HWY_NOINLINE V shareOf(const ShadowLookup& shadow, const Vector& at, const Vector& normal, const Vector& towards,
                         V cosine, M needed) const {
    const D d;
    const V start = hn::Set(d, shadow.start()), missing = fusedLess(start, cosine, start);
    const auto moved = [&](V from, V across, V along) { return fused(missing, across, fused(start, along, from)); };
    return shareAt(
        shadow, {moved(at.x, normal.x, towards.x), moved(at.y, normal.y, towards.y), moved(at.z, normal.z, towards.z)},
        needed);
  }

  HWY_NOINLINE V shareAt(const ShadowLookup& shadow, const Vector& at, M needed) const {
    const D d;
    const V one = hn::Set(d, 1.0f);
    V sum = hn::Zero(d);
    for (const std::vector<ShadowLookup::Map>& maps : shadow.points()) {
      // A point near the volume has a map for each face of a cube: each lane needs its own.
      if (maps.size() > 1) return shareOneByOne(shadow, at, needed);
      sum = hn::Add(sum, transmittanceAt(maps.front(), at, needed));
    }
    const V mean = hn::Div(sum, hn::Set(d, static_cast<float>(shadow.points().size())));
    return fusedLess(hn::Set(d, shadow.strength()), hn::Sub(one, mean), one);
  }

  // The vector form of DeepShadowMap::transmittance: a lane reads knots only near layers.
  HWY_INLINE V transmittanceAt(const ShadowLookup::Map& of, const Vector& at, M needed) const {
    const D d;
    const DI di;
    const DeepShadowMap::Frame& f = of.map->frame();
    const glm::mat4& m = of.light_from_view;
    const Vector turned = turnedBy(glm::mat3(m), at);
    const V z = hn::Add(turned.z, hn::Set(d, m[3][2]));
    const V focal = hn::Set(d, f.focal), scale = f.perspective ? hn::Div(focal, z) : focal;
    // A lane without a sample may hold any number, also none.
    const auto inside = [&](V v, float last) {
      const V low = hn::IfThenElseZero(hn::Gt(v, hn::Zero(d)), v);
      return hn::IfThenElse(hn::Lt(low, hn::Set(d, last)), low, hn::Set(d, last));
    };
    const V x = inside(fused(scale, hn::Add(turned.x, hn::Set(d, m[3][0])), hn::Set(d, f.centre_x)), f.last_x);
    const V y = inside(fused(scale, hn::Add(turned.y, hn::Set(d, m[3][1])), hn::Set(d, f.centre_y)), f.last_y);
    const V depth = inside(hn::Mul(hn::Sub(z, hn::Set(d, f.near)), hn::Set(d, f.per_depth)), DeepShadowMap::kSteps);
    const VI x0 = hn::Min(hn::ConvertTo(di, x), hn::Set(di, f.width - 2));
    const VI y0 = hn::Min(hn::ConvertTo(di, y), hn::Set(di, f.height - 2));
    const VI place = hn::Add(x0, hn::Mul(y0, hn::Set(di, f.stride)));
    const VI span = hn::GatherIndex(di, of.map->spans(), place), low = hn::Set(di, 0xffff);
    const VI whole = hn::ConvertTo(di, depth);
    const M lit = hn::RebindMask(d, hn::Gt(hn::And(span, low), whole));
    const M dark = hn::RebindMask(d, hn::Gt(whole, hn::And(hn::ShiftRight<16>(span), low)));
    const V out = hn::IfThenElseZero(lit, hn::Set(d, 1.0f));
    const M between = hn::And(needed, hn::Not(hn::Or(lit, dark)));
    return hn::AllFalse(d, between) ? out : betweenLayers(*of.map, place, {x, y, depth}, {x0, y0}, between, out);
  }

  // Number of depths that are not above `whole`, in a comparison or two.
  static HWY_INLINE std::size_t passedIn(const DeepShadowMap::Depths& depths, std::uint16_t whole) {
    const hn::CappedTag<std::uint16_t, kShadowKnots> d;
    std::size_t behind = 0;
    for (std::size_t i = 0; i < depths.size(); i += hn::Lanes(d))
      behind += hn::CountTrue(d, hn::Gt(hn::LoadU(d, depths.data() + i), hn::Set(d, whole)));
    return depths.size() - behind;
  }

  // A bit for each lane of a mask.
  static HWY_INLINE std::uint32_t bitsOf(M mask) {
    const D d;
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, mask, bytes);
    return bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8;
  }

  struct Pixels {
    VI x, y;
  };
  // `at`: pixels and depth of the samples; `first`: the pixels before them.
  static HWY_NOINLINE V betweenLayers(const DeepShadowMap& map, VI place, const Vector& at, const Pixels& first,
                                      M between, V out) {
    const D d;
    const DI di;
    constexpr std::size_t kLanes = hn::MaxLanes(D());
    constexpr auto kPassed = [](const DeepShadowMap::Depths& z, std::uint16_t whole)
                                 HWY_ATTR { return passedIn(z, whole); };
    const std::int32_t beside[4] = {0, 1, map.frame().stride, map.frame().stride + 1};
    alignas(64) std::int32_t places[kLanes], whole[kLanes];
    alignas(64) std::int32_t depths[4][kLanes] = {}, shares[4][kLanes] = {};
    hn::Store(place, di, places);
    hn::Store(hn::ConvertTo(di, at.z), di, whole);
    for (std::uint32_t lanes = bitsOf(between); lanes != 0; lanes &= lanes - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(lanes));
      for (int corner = 0; corner < 4; ++corner) {
        const auto piece = map.pieceAt(places[i] + beside[corner], static_cast<std::uint16_t>(whole[i]), kPassed);
        depths[corner][i] = static_cast<std::int32_t>(piece.depths);
        shares[corner][i] = static_cast<std::int32_t>(piece.shares);
      }
    }
    const V one = hn::Set(d, 1.0f), zero = hn::Zero(d);
    const VI low = hn::Set(di, 0xffff);
    const auto first_of = [&](VI ends) { return hn::ConvertTo(d, hn::And(ends, low)); };
    const auto last_of = [&](VI ends) { return hn::ConvertTo(d, hn::And(hn::ShiftRight<16>(ends), low)); };
    const auto through = [&](int corner) {
      const VI z = hn::Load(di, depths[corner]), t = hn::Load(di, shares[corner]);
      const V near = first_of(z), before = first_of(t);
      const V part = hn::Div(hn::Sub(at.z, near), hn::Max(hn::Sub(last_of(z), near), one));
      return fused(hn::Min(hn::Max(part, zero), one), hn::Sub(last_of(t), before), before);
    };
    const auto mix = [](V a, V b, V share) { return fused(share, hn::Sub(b, a), a); };
    const V fx = hn::Sub(at.x, hn::ConvertTo(d, first.x)), fy = hn::Sub(at.y, hn::ConvertTo(d, first.y));
    const V found = mix(mix(through(0), through(1), fx), mix(through(2), through(3), fx), fy);
    return hn::IfThenElse(between, hn::Mul(found, hn::Set(d, 1 / DeepShadowMap::kSteps)), out);
  }

  HWY_NOINLINE V shareOneByOne(const ShadowLookup& shadow, const Vector& at, M needed) const {
    const D d;
    constexpr std::size_t kLanes = hn::MaxLanes(D());
    alignas(64) float x[kLanes], y[kLanes], z[kLanes], share[kLanes];
    hn::Store(at.x, d, x), hn::Store(at.y, d, y), hn::Store(at.z, d, z);
    hn::Store(hn::IfThenElseZero(needed, hn::Set(d, 1.0f)), d, share);
    for (std::size_t i = 0; i < hn::Lanes(d); ++i) {
      if (share[i] != 0) share[i] = shadow.share({x[i], y[i], z[i]});
    }
    return hn::Load(d, share);
  }

  // Share of ambient light: the vector form of AmbientLookup, with numbers of 16 bits between cells.
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
      const V p = fused(along[axis], hn::Set(d, AmbientLookup::kAhead), hn::Add(place[axis], hn::Set(d, m[3][axis])));
      const V inside = hn::Min(hn::Max(p, hn::Zero(d)), hn::Set(d, static_cast<float>(n[axis] - 1)));
      cell[axis] = hn::Min(hn::ConvertTo(di, inside), hn::Set(di, static_cast<std::int32_t>(n[axis]) - 2));
      part[axis] = hn::Sub(inside, hn::ConvertTo(d, cell[axis]));
    }
    const auto width = static_cast<std::int32_t>(n.x), plane = static_cast<std::int32_t>(n.x * n.y);
    const VI first =
        hn::Add(cell[0], hn::Add(hn::Mul(cell[1], hn::Set(di, width)), hn::Mul(cell[2], hn::Set(di, plane))));
    const auto* const cells = reinterpret_cast<const std::int32_t*>(ambient.grid().cells());
    const CellShare along_x(part[0]), along_y(part[1]), along_z(part[2]);
    const CellRows rows(cells, first, width, plane);
    const auto row = [&](std::size_t of) {
      const CellPair pair = rows.row(of);
      return CellBytes::between(CellBytes::of(pair.here), CellBytes::of(pair.after), along_x);
    };
    const auto layer = [&](std::size_t of) { return CellBytes::between(row(of), row(of + 1), along_y); };
    const auto [even, odd] = CellBytes::between(layer(0), layer(2), along_z);
    // The cell's bytes, from the lowest: mean, x, y, z.
    constexpr float kByte = 1 / (256 * CellShare::kWhole);
    const auto byte = [&](VI of) { return hn::ConvertTo(d, of); };
    const V turned_mean = dotOf({byte(odd.lower()), byte(even.upper()), byte(odd.upper())}, turned);
    const V mean = fused(byte(even.lower()), hn::Set(d, kByte * AmbientCell::kMean),
                         hn::Set(d, AmbientCell::kMean * AmbientCell::kHalfOpen));
    const V seen = fused(turned_mean, hn::Set(d, 2 * kByte * AmbientCell::kAlong), mean);
    const V one = hn::Set(d, 1.0f), shut = hn::Sub(one, hn::Min(hn::Max(seen, hn::Zero(d)), one));
    return fusedLess(hn::Set(d, ambient.strength()), shut, one);
  }

  const Shader::Model& s_;
  const bool perspective_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
