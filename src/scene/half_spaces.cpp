#include "scene/half_spaces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <optional>

namespace kiln {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// The edge in which two planes meet, if the other half-spaces leave an edge.
std::optional<Edge> edgeOf(std::span<const glm::dvec4> planes, std::size_t a, std::size_t b) {
  constexpr double kParallel = 1e-12, kInside = 1e-9;
  const glm::dvec3 m(planes[a]), n(planes[b]), along = glm::cross(m, n);
  const double sine2 = glm::dot(along, along);
  if (sine2 < kParallel) return std::nullopt;
  // The point of both planes nearest to the origin.
  const glm::dvec3 base = glm::cross(planes[b].w * m - planes[a].w * n, along) / sine2;
  double lo = -kUnbounded, hi = kUnbounded;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (i == a || i == b) continue;
    const double at_base = glm::dot(glm::dvec3(planes[i]), base) + planes[i].w;
    const double change = glm::dot(glm::dvec3(planes[i]), along);
    if (std::abs(change) < kParallel) {
      if (at_base < -kInside) return std::nullopt;
      continue;
    }
    (change > 0 ? lo : hi) = change > 0 ? std::max(lo, -at_base / change) : std::min(hi, -at_base / change);
  }
  if (!(lo <= hi) || std::isinf(lo) || std::isinf(hi)) return std::nullopt;
  return Edge{base + lo * along, base + hi * along};
}

}  // namespace

void addBox(const glm::dvec3& lo, const glm::dvec3& hi, std::vector<glm::dvec4>& half_spaces) {
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec4 lower(0, 0, 0, -lo[axis]), upper(0, 0, 0, hi[axis]);
    lower[axis] = 1, upper[axis] = -1;
    half_spaces.push_back(lower);
    half_spaces.push_back(upper);
  }
}

glm::dvec4 inIndexSpace(const glm::dvec4& half_space, const glm::dmat4& world_from_index) {
  const glm::dvec4 out = glm::transpose(world_from_index) * half_space;
  return out / glm::length(glm::dvec3(out));
}

bool cuts(const glm::dvec4& half_space, const Extent3& dims) {
  constexpr double kRounding = 1e-6;  // of a plane's place. unit: voxels
  const glm::dvec3 normal(half_space), size(dims.x, dims.y, dims.z);
  const glm::dvec3 least = glm::min(normal * -0.5, normal * (size - 0.5));
  return least.x + least.y + least.z + half_space.w < -kRounding * glm::length(normal);
}

std::vector<Edge> edgesOf(std::span<const glm::dvec4> half_spaces) {
  std::vector<Edge> out;
  for (std::size_t a = 0; a < half_spaces.size(); ++a) {
    for (std::size_t b = a + 1; b < half_spaces.size(); ++b) {
      if (const std::optional<Edge> edge = edgeOf(half_spaces, a, b)) out.push_back(*edge);
    }
  }
  return out;
}

}  // namespace kiln
