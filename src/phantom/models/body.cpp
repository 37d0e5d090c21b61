#include "phantom/models/body.h"

#include <algorithm>

namespace kiln::phantom {

PartList bodyParts() {
  PartList parts = {bodySurface()};
  for (PartList (*region)() : {trunkCavities, organs, vessels, spineAndRibs, spinalCord, limbBones, handAndFootBones,
                               skull, headContents, teeth, airways}) {
    const PartList more = region();
    parts.insert(parts.end(), more.begin(), more.end());
  }
  return parts;
}

std::vector<ShapeSpec> chain(const std::vector<glm::dvec3>& points, double first_radius, double last_radius) {
  std::vector<ShapeSpec> out;
  const double pieces = static_cast<double>(points.size()) - 1;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const double t = static_cast<double>(i) / pieces, u = static_cast<double>(i + 1) / pieces;
    out.push_back(cone(points[i], points[i + 1], (1 - t) * first_radius + t * last_radius,
                       (1 - u) * first_radius + u * last_radius));
  }
  return out;
}

std::vector<glm::dvec3> curve(const std::vector<glm::dvec3>& points, int steps_a_piece) {
  std::vector<glm::dvec3> out = {points.front()};
  const auto at = [&](std::size_t i) { return points[std::min(i, points.size() - 1)]; };
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const glm::dvec3 p0 = at(i == 0 ? 0 : i - 1), p1 = at(i), p2 = at(i + 1), p3 = at(i + 2);
    for (int step = 1; step <= steps_a_piece; ++step) {
      const double t = static_cast<double>(step) / steps_a_piece;
      out.push_back(0.5 * (2.0 * p1 + (p2 - p0) * t + (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) * t * t +
                           (3.0 * p1 - p0 - 3.0 * p2 + p3) * t * t * t));
    }
  }
  return out;
}

std::vector<ShapeSpec> with(std::vector<ShapeSpec> shapes, double blend_mm, double shell_mm) {
  for (ShapeSpec& shape : shapes) {
    shape.blend_mm = blend_mm;
    shape.shell_mm = shell_mm;
  }
  return shapes;
}

}  // namespace kiln::phantom
