// Normals of samples at the border of a volume, whose gradients would need voxels beyond it. Compiled once for each
// instruction set; hence no #pragma once.
#if defined(KILN_BORDER_SLOPES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_BORDER_SLOPES_INL_H
#undef KILN_BORDER_SLOPES_INL_H
#else
#define KILN_BORDER_SLOPES_INL_H
#endif

#include <hwy/highway.h>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "engine/pixel/cell_places-inl.h"
#include "engine/shared/sample_math-inl.h"
#include "scene/clip_region.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

class BorderSlopes {
 public:
  BorderSlopes(const CellPlaces& places, const RaySampling& rays, const SampleLattice& lattice)
      : p_(places), r_(rays), l_(lattice) {}

  struct Slopes {
    Vector slope;
    M on_face;
  };
  // Replaces the gradients of samples less than a voxel inside the volume's border by the normal of the face that is
  // nearest towards the eye, as ClipRegion::cutGradient does.
  HWY_NOINLINE Slopes replaced(const CellPlaces::Where& w, const Sight& sight, Vector slope) const {
    const D d;
    const V far = hn::Set(d, CellPlaces::kFar);
    M on_face = hn::FirstN(d, 0);
    const V none = hn::Zero(d), normal = hn::Set(d, l_.light.gradient.directed);
    V nearest = far;
    for (int a = 0; a < 3; ++a) {
      const V at = p_.indexOf(a, w, 0);
      const auto from_anchor = [&](double index) {
        return hn::Set(d, static_cast<float>(index - static_cast<double>(r_.anchor[a])));
      };
      // Cosine of the axis and the direction from the eye, times a length.
      const glm::vec3& m = l_.light.view_from_index_gradient[a];
      const V along = hn::Set(d, m.z);
      const float edge_on = static_cast<float>(ClipRegion::kEdgeOn) * glm::length(m);
      const V away = l_.perspective ? fused(hn::Set(d, m.x), sight.u, fused(hn::Set(d, m.y), sight.v, along)) : along;
      const V inside =
          hn::Min(hn::IfThenElse(hn::Gt(away, hn::Set(d, edge_on)), hn::Sub(at, from_anchor(-0.5)), far),
                  hn::IfThenElse(hn::Lt(away, hn::Set(d, -edge_on)), hn::Sub(from_anchor(r_.volume_hi[a]), at), far));
      const V distance = hn::Div(inside, hn::Max(hn::Abs(away), hn::Set(d, edge_on)));
      const M lit = hn::And(hn::Lt(inside, hn::Set(d, 1.0f)), hn::Lt(distance, nearest));
      nearest = hn::IfThenElse(lit, distance, nearest);
      on_face = hn::Or(on_face, lit);
      slope.x = hn::IfThenElse(lit, a == 0 ? normal : none, slope.x);
      slope.y = hn::IfThenElse(lit, a == 1 ? normal : none, slope.y);
      slope.z = hn::IfThenElse(lit, a == 2 ? normal : none, slope.z);
    }
    return {slope, on_face};
  }

 private:
  const CellPlaces& p_;
  const RaySampling& r_;
  const SampleLattice& l_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
