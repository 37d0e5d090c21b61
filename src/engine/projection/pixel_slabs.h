// A pixel's ray through a level's lattice, and a span of a zone's slabs. A slab's position is the point where the ray
// meets its middle.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/shared/index_ray.h"
#include "engine/shared/projector.h"
#include "engine/shared/slab_grid.h"

namespace kiln {

class PixelRay {
 public:
  /// Ray through a point of the picture. unit: pixels. requires: `projector` belongs to the level.
  PixelRay(const Projector& projector, const glm::dvec2& place) {
    const glm::dvec2 across((place.x - projector.centre().x) / projector.focal(),
                            (place.y - projector.centre().y) / projector.focal());
    for (int axis = 0; axis < 3; ++axis) {
      const glm::dvec4& row = projector.indexRow(axis);
      const double lateral = row.x * across.x + row.y * across.y;
      ray_.base[axis] = projector.perspective() ? row.w : row.w + lateral;
      ray_.slope[axis] = projector.perspective() ? row.z + lateral : row.z;
    }
    if (projector.perspective()) oblique_ = std::sqrt(1 + across.x * across.x + across.y * across.y);
  }
  /// The ray's point at a depth is base + slope · depth, in the level's index space.
  const IndexRay& inIndexSpace() const { return ray_; }
  const glm::dvec3& base() const { return ray_.base; }
  const glm::dvec3& slope() const { return ray_.slope; }
  /// Length of the ray per depth.
  double oblique() const { return oblique_; }

 private:
  IndexRay ray_;
  double oblique_ = 1;
};

/// Slabs [first, end).
struct SlabSpan {
  int first = 0, end = 0;
  bool empty() const { return first >= end; }
};

}  // namespace kiln
