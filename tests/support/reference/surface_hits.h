// Crossings of a ray with an iso-surface, in double precision: small steps, then bisection.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "scene/render_options.h"
#include "support/reference/reference_field.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/procedural.h"

namespace kiln::test {

struct SurfaceHit {
  double along = 0;      // distance from Ray::origin. unit: world
  glm::dvec3 normal{0};  // unit vector of the world, from the gradient, turned towards the eye
};

/// thread: safe.
class SurfaceHits {
 public:
  /// Crossings less than a step apart may be missed. unit: `step`: the shortest edge of a voxel.
  SurfaceHits(const DenseVolume& volume, Interpolation interpolation, double step);

  /// Returns the crossings of the ray from its begin on, front to back. Values from `value` on are inside.
  std::vector<SurfaceHit> along(const Ray& ray, double value) const;

 private:
  glm::dvec3 indexAt(const Ray& ray, double along) const;
  bool inside(const Ray& ray, double along, double value) const;

  ReferenceField field_;
  Extent3 dims_;
  glm::dmat4 index_from_world_;
  glm::dmat3 gradient_world_from_index_;
  double step_;  // unit: world
};

}  // namespace kiln::test
