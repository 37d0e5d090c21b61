// Rays in a level's index space, and depths along them.
#pragma once

#include <algorithm>
#include <glm/vec3.hpp>

namespace kiln {

/// Depths [near, far) along a ray.
struct DepthSpan {
  double near, far;
  bool empty() const { return !(near < far); }
};

/// The points base + slope · depth of a level's index space.
struct IndexRay {
  glm::dvec3 base, slope;

  glm::dvec3 at(double depth) const { return base + depth * slope; }
  /// Returns the part of `depths` whose points lie in [lo, hi); empty if there is none.
  DepthSpan within(const glm::dvec3& lo, const glm::dvec3& hi, DepthSpan depths) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (slope[axis] == 0) {
        if (base[axis] < lo[axis] || base[axis] >= hi[axis]) return {0, 0};
        continue;
      }
      const double a = (lo[axis] - base[axis]) / slope[axis], b = (hi[axis] - base[axis]) / slope[axis];
      depths.near = std::max(depths.near, slope[axis] > 0 ? a : b);
      depths.far = std::min(depths.far, slope[axis] > 0 ? b : a);
    }
    return depths;
  }
};

}  // namespace kiln
