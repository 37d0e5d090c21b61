#include "engine/shown_outline.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <tuple>

#include "base/thread/parallel.h"
#include "grid/spirals.h"

namespace kiln {
namespace {

glm::dvec3 directionOf(int i) { return pointOfSphere(i, kOutlineDirections); }

// The corner of some box that reaches farthest along a direction of index space, in voxels' edges.
VoxelCoord farthestCorner(const std::vector<VoxelBox>& boxes, const glm::dvec3& along) {
  const auto corner = [&](const VoxelBox& box) {
    return VoxelCoord{(along.x > 0 ? box.hi : box.lo).x, (along.y > 0 ? box.hi : box.lo).y,
                      (along.z > 0 ? box.hi : box.lo).z};
  };
  VoxelCoord out;
  double farthest = -INFINITY;
  for (const VoxelBox& box : boxes) {
    const VoxelCoord at = corner(box);
    const double reach = glm::dot(along, glm::dvec3(at.x, at.y, at.z));
    if (reach > farthest) farthest = reach, out = at;
  }
  return out;
}

}  // namespace

std::vector<glm::dvec3> outlineOf(const std::vector<VoxelBox>& boxes, const VolumeGeometry& volume) {
  if (boxes.empty()) return {};
  // Reach along a direction of the world is the reach along the transposed direction of index space.
  const glm::dmat3 index_from_direction = glm::transpose(glm::dmat3(volume.world_from_index));
  std::vector<VoxelCoord> corners(kOutlineDirections);
  parallelFor(corners.size(), [&](std::size_t i) {
    corners[i] = farthestCorner(boxes, index_from_direction * directionOf(static_cast<int>(i)));
  });
  std::ranges::sort(corners, {}, [](const VoxelCoord& c) { return std::tuple(c.x, c.y, c.z); });
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  std::vector<glm::dvec3> out;
  for (const VoxelCoord& corner : corners)
    out.push_back(volume.worldOf(glm::dvec3(corner.x, corner.y, corner.z) - 0.5));
  return out;
}

}  // namespace kiln
