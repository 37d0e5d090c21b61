// The box around points.
#pragma once

#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <limits>

namespace kiln {

/// Without points, `lo` lies above `hi`.
struct PointBounds {
  glm::dvec3 lo{std::numeric_limits<double>::infinity()}, hi{-std::numeric_limits<double>::infinity()};
  void add(const glm::dvec3& point) { lo = glm::min(lo, point), hi = glm::max(hi, point); }
};

}  // namespace kiln
