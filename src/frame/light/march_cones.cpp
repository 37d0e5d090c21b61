#include "frame/light/march_cones.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "frame/light/march_cones.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/shared/sample_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

// Returns the cell of `level` at `p` along an axis, counted from the stored border.
HWY_INLINE VI storedCell(V p, V scale, float offset, std::int64_t cells) {
  const D d;
  const V at = hn::Add(hn::Mul(p, scale), hn::Set(d, offset));
  const V inside = hn::Min(hn::Max(at, hn::Zero(d)), hn::Set(d, static_cast<float>(cells + 1)));
  return hn::ConvertTo(DI(), inside);
}

HWY_INLINE V lookUp(const OpenLevel& level, VI x, VI y, VI z) {
  const D d;
  const DI di;
  const Extent3 n = level.stored();
  const VI row = hn::Add(hn::Mul(z, hn::Set(di, static_cast<std::int32_t>(n.y))), y);
  const VI place = hn::Add(hn::Mul(row, hn::Set(di, static_cast<std::int32_t>(n.x))), x);
  const VI word = hn::GatherIndex(di, level.words(), hn::ShiftRight<2>(place));
  const VI bits = hn::ShiftLeft<3>(hn::And(place, hn::Set(di, 3)));
  return hn::Mul(hn::ConvertTo(d, hn::And(hn::Shr(word, bits), hn::Set(di, 255))), hn::Set(d, 1.0f / 255));
}

HWY_INLINE V seenAlong(const Cones& cones, const glm::vec3& direction, V x, V y, V z) {
  const D d;
  V open = hn::Set(d, 1.0f), seen = open;
  for (const ConeStep& step : cones.steps) {
    const OpenLevel& level = cones.levels[static_cast<std::size_t>(step.level)];
    const float scale = 1.0f / static_cast<float>(1 << step.level), along = scale * step.at;
    const V scales = hn::Set(d, scale);
    const V through = lookUp(level, storedCell(x, scales, along * direction.x + 1, level.cells().x),
                             storedCell(y, scales, along * direction.y + 1, level.cells().y),
                             storedCell(z, scales, along * direction.z + 1, level.cells().z));
    const V after = hn::Mul(open, through);
    seen = hn::Sub(seen, hn::Mul(hn::Sub(open, after), hn::Set(d, step.weight)));
    open = hn::IfThenElseZero(hn::Ge(after, hn::Set(d, kDarkCone)), after);
    if (hn::AllTrue(d, hn::Eq(open, hn::Zero(d)))) break;
  }
  return seen;
}

// Share of the light that reaches an even surface: the lattice has stairs, and the rest would show as rings.
constexpr float kReaching = 1 / 1.01f;

std::size_t lanes() { return hn::Lanes(D()); }

// requires: `count` fills vectors.
void marchConesOn(const Cones& cones, const float* px, const float* py, const float* pz, std::size_t count,
                  AmbientCell* out) {
  const D d;
  const DI di;
  const float directions = kReaching * static_cast<float>(cones.directions.size());
  constexpr float kOpen = 2 * AmbientCell::kHalfOpen;
  const V mean_unit = hn::Set(d, kOpen / directions), along_unit = hn::Set(d, 4 * 127 / directions);
  const auto rounded = [&](V sum, V unit, float least, float most) {
    return hn::NearestInt(hn::Min(hn::Max(hn::Mul(sum, unit), hn::Set(d, least)), hn::Set(d, most)));
  };
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const V x = hn::LoadU(d, px + i), y = hn::LoadU(d, py + i), z = hn::LoadU(d, pz + i);
    V mean = hn::Zero(d), along_x = mean, along_y = mean, along_z = mean;
    for (const glm::vec3& direction : cones.directions) {
      const V seen = seenAlong(cones, direction, x, y, z);
      mean = hn::Add(mean, seen);
      along_x = hn::Add(along_x, hn::Mul(seen, hn::Set(d, direction.x)));
      along_y = hn::Add(along_y, hn::Mul(seen, hn::Set(d, direction.y)));
      along_z = hn::Add(along_z, hn::Mul(seen, hn::Set(d, direction.z)));
    }
    const auto byte = [&](V sum) { return hn::And(rounded(sum, along_unit, -127, 127), hn::Set(di, 255)); };
    // The cell's bytes, from the lowest: mean, x, y, z.
    const VI closed = hn::Sub(rounded(mean, mean_unit, 0, kOpen), hn::Set(di, AmbientCell::kHalfOpen));
    const VI lower = hn::Or(hn::And(closed, hn::Set(di, 255)), hn::ShiftLeft<8>(byte(along_x)));
    const VI upper = hn::Or(hn::ShiftLeft<16>(byte(along_y)), hn::ShiftLeft<24>(byte(along_z)));
    hn::StoreU(hn::Or(lower, upper), di, reinterpret_cast<std::int32_t*>(out) + i);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {

HWY_EXPORT(lanes);
HWY_EXPORT(marchConesOn);

OpenLevel::OpenLevel(const Extent3& cells) : cells_(cells) {
  words_.assign(static_cast<std::size_t>(stored().count() + 3) / 4, -1);
}

void marchCones(const Cones& cones, ConePoints& points, std::vector<AmbientCell>& out) {
  const std::size_t lanes = HWY_DYNAMIC_DISPATCH(lanes)();
  while (points.size() % lanes != 0) points.add({points.x.back(), points.y.back(), points.z.back()});
  out.resize(points.size());
  HWY_DYNAMIC_DISPATCH(marchConesOn)
  (cones, points.x.data(), points.y.data(), points.z.data(), points.size(), out.data());
}

}  // namespace kiln
#endif
