// Points that a spiral spreads evenly over a disc or a sphere, for any number of points, without a preferred direction.
#pragma once

#include <cmath>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <numbers>

namespace kiln {

/// Returns the angle of point i: i times the golden angle. unit: radians.
inline double angleOfSpiral(int i) { return i * std::numbers::pi * (3 - std::sqrt(5.0)); }

/// Returns point i of `count`, spread evenly over a disc about the origin. unit: that of `radius`. Source: Vogel 1979.
inline glm::dvec2 pointOfDisc(int i, int count, double radius) {
  const double r = radius * std::sqrt((i + 0.5) / count), angle = angleOfSpiral(i);
  return r * glm::dvec2(std::cos(angle), std::sin(angle));
}

/// Returns unit vector i of `count`, spread evenly over the sphere. Source: Swinbank and Purser 2006.
inline glm::dvec3 pointOfSphere(int i, int count) {
  const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z), angle = angleOfSpiral(i);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

}  // namespace kiln
