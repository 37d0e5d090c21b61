#include "surface_hits.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace kiln::test {

SurfaceHits::SurfaceHits(const DenseVolume& volume, Interpolation interpolation, double step)
    : field_(volume, interpolation),
      dims_(volume.geometry.dims),
      index_from_world_(glm::inverse(volume.geometry.world_from_index)),
      gradient_world_from_index_(glm::transpose(glm::inverse(glm::dmat3(volume.geometry.world_from_index)))),
      step_(step * volume.geometry.shortestEdge()) {}

std::vector<SurfaceHit> SurfaceHits::along(const Ray& ray, double value) const {
  double begin = ray.begin, end = 1e30;
  const glm::dvec3 origin = indexAt(ray, 0), direction = indexAt(ray, 1) - origin;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (-0.5 - origin[axis]) / direction[axis];
    const double b = (static_cast<double>(dims_[axis]) - 0.5 - origin[axis]) / direction[axis];
    begin = std::max(begin, std::min(a, b)), end = std::min(end, std::max(a, b));
  }
  std::vector<SurfaceHit> out;
  if (!(begin < end)) return out;
  bool before = inside(ray, begin, value);
  for (double from = begin; from < end; from += step_) {
    const double to = std::min(from + step_, end);
    const bool after = inside(ray, to, value);
    if (before == after) continue;
    double lo = from, hi = to;
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (lo + hi);
      (inside(ray, middle, value) == before ? lo : hi) = middle;
    }
    SurfaceHit hit{0.5 * (lo + hi), {}};
    const glm::dvec3 gradient = gradient_world_from_index_ * field_.gradient(indexAt(ray, hit.along));
    if (glm::length(gradient) > 0) hit.normal = glm::normalize(gradient);
    if (glm::dot(hit.normal, ray.direction) > 0) hit.normal = -hit.normal;
    out.push_back(hit);
    before = after;
  }
  return out;
}

glm::dvec3 SurfaceHits::indexAt(const Ray& ray, double along) const {
  return glm::dvec3(index_from_world_ * glm::dvec4(ray.origin + along * ray.direction, 1));
}

bool SurfaceHits::inside(const Ray& ray, double along, double value) const {
  return field_.at(indexAt(ray, along)) >= value;
}

}  // namespace kiln::test
