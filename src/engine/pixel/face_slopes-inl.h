// Normals of samples at cuts and at the border of a volume, whose gradients would need voxels beyond them. Compiled
// once for each instruction set; hence no #pragma once.
#if defined(KILN_FACE_SLOPES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_FACE_SLOPES_INL_H
#undef KILN_FACE_SLOPES_INL_H
#else
#define KILN_FACE_SLOPES_INL_H
#endif

#include <hwy/highway.h>

#include "engine/pixel/cell_places-inl.h"
#include "engine/shared/sample_math-inl.h"
#include "scene/clip_region.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

class FaceSlopes {
 public:
  FaceSlopes(const CellPlaces& places, const RaySampling& rays, const CellInput& in) : p_(places), r_(rays), in_(in) {}

  struct Slopes {
    Vector slope;
    M on_face;
  };
  // Replaces the gradients of samples less than a voxel behind the face that is nearest towards the eye by the normal
  // of the face, as ClipRegion::cutGradient does.
  HWY_NOINLINE Slopes replaced(const CellPlaces::Where& w, const Vector& slope) const {
    const D d;
    const Vector at{p_.indexOf(0, w, 0), p_.indexOf(1, w, 0), p_.indexOf(2, w, 0)};
    const Vector step{CellPlaces::linear(r_.step, 0, w), CellPlaces::linear(r_.step, 1, w),
                      CellPlaces::linear(r_.step, 2, w)};
    const V edge_on = hn::Mul(hn::Set(d, static_cast<float>(ClipRegion::kEdgeOn)), hn::Sqrt(dotOf(step, step)));
    M on_face = hn::FirstN(d, 0);
    V nearest = hn::Set(d, CellPlaces::kFar);
    Vector normal_of_face = slope;
    for (const SampleFace& face : in_.lit_by) {
      const Vector normal = vectorOf(face.normal);
      const V inside = hn::Add(dotOf(normal, at), hn::Set(d, face.offset)), rate = dotOf(normal, step);
      // A face looks at the eye if rays enter through the face.
      const M looks = hn::Gt(rate, edge_on);
      const V distance = hn::Div(inside, hn::IfThenElse(looks, rate, hn::Set(d, 1.0f)));
      const M nearer = hn::And(looks, hn::Lt(distance, nearest)),
              lit = hn::And(nearer, hn::Lt(inside, hn::Set(d, face.voxel)));
      nearest = hn::IfThenElse(nearer, distance, nearest);
      on_face = hn::Or(hn::AndNot(nearer, on_face), lit);
      normal_of_face.x = hn::IfThenElse(lit, hn::Set(d, face.slope.x), normal_of_face.x);
      normal_of_face.y = hn::IfThenElse(lit, hn::Set(d, face.slope.y), normal_of_face.y);
      normal_of_face.z = hn::IfThenElse(lit, hn::Set(d, face.slope.z), normal_of_face.z);
    }
    return {{hn::IfThenElse(on_face, normal_of_face.x, slope.x), hn::IfThenElse(on_face, normal_of_face.y, slope.y),
             hn::IfThenElse(on_face, normal_of_face.z, slope.z)},
            on_face};
  }

 private:
  const CellPlaces& p_;
  const RaySampling& r_;
  const CellInput& in_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
