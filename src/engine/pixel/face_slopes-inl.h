// Normals of samples at cuts and at the border of a volume, whose gradients would need voxels beyond them: the rule of
// ClipRegion::cutGradient, for pieces of rays. Compiled once for each instruction set; hence no #pragma once.
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

  // Normal of the face that is nearest towards the eye, and the share of a sample's piece within a voxel of the face.
  struct Face {
    Vector slope;  // as long as a gradient of a direction
    V share;       // 0: the face does not light the sample
  };
  HWY_NOINLINE Face at(const CellPlaces::Where& w) const {
    const D d;
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const Vector at{p_.indexOf(0, w, 0), p_.indexOf(1, w, 0), p_.indexOf(2, w, 0)};
    const Vector step{CellPlaces::linear(r_.step, 0, w), CellPlaces::linear(r_.step, 1, w),
                      CellPlaces::linear(r_.step, 2, w)};
    const V edge_on = hn::Mul(hn::Set(d, static_cast<float>(ClipRegion::kEdgeOn)), hn::Sqrt(dotOf(step, step)));
    V nearest = hn::Set(d, CellPlaces::kFar);
    Face out{{zero, zero, zero}, zero};
    for (const SampleFace& face : in_.lit_by) {
      const Vector normal = vectorOf(face.normal);
      const V inside = hn::Add(dotOf(normal, at), hn::Set(d, face.offset)), rate = dotOf(normal, step);
      // A face looks at the eye if rays enter through the face.
      const M looks = hn::Gt(rate, edge_on);
      const V distance = hn::Div(inside, hn::IfThenElse(looks, rate, one));
      const M nearer = hn::And(looks, hn::Lt(distance, nearest));
      nearest = hn::IfThenElse(nearer, distance, nearest);
      // Depth of the piece along the normal, and the part of the depth within a voxel of the face.
      const V depth = hn::Max(hn::Mul(w.slabs, rate), hn::Set(d, kLeastDepth));
      const V near = fused(hn::Set(d, 0.5f), depth, hn::Sub(hn::Set(d, face.voxel), inside));
      const V share = hn::Min(hn::Max(hn::Div(near, depth), zero), one);
      out.share = hn::IfThenElse(nearer, share, out.share);
      out.slope.x = hn::IfThenElse(nearer, hn::Set(d, face.slope.x), out.slope.x);
      out.slope.y = hn::IfThenElse(nearer, hn::Set(d, face.slope.y), out.slope.y);
      out.slope.z = hn::IfThenElse(nearer, hn::Set(d, face.slope.z), out.slope.z);
    }
    return out;
  }

 private:
  // A piece without depth is on one side. unit: voxels.
  static constexpr float kLeastDepth = 1e-6f;

  const CellPlaces& p_;
  const RaySampling& r_;
  const CellInput& in_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
