#include "engine/pixel/sample_faces.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "engine/pixel/ray_sampling.h"

namespace kiln {
namespace {

glm::dvec3 anchorOf(const Extent3& dims) {
  const VoxelCoord out = RaySampling::anchorOf(dims);
  return {out.x, out.y, out.z};
}

}  // namespace

std::vector<SampleFace> sampleFaces(const ClipRegion& clip, const Extent3& dims, float slope) {
  std::vector<SampleFace> out;
  for (const auto& [half_space, cuts, open] : clip.faces()) {
    const double length = glm::length(glm::dvec3(half_space));
    const glm::dvec3 normal = glm::dvec3(half_space) / length, size = glm::abs(normal);
    out.push_back({glm::vec3(normal), static_cast<float>(half_space.w / length + glm::dot(normal, anchorOf(dims))),
                   static_cast<float>(size.x + size.y + size.z), slope * glm::vec3(normal), cuts, open});
  }
  return out;
}

float leastInside(const SampleFace& face, const VoxelBox& voxels, const Extent3& dims) {
  const glm::dvec3 lo(voxels.lo.x, voxels.lo.y, voxels.lo.z), hi(voxels.hi.x, voxels.hi.y, voxels.hi.z);
  const glm::dvec3 middle = 0.5 * (lo + hi) - 0.5 - anchorOf(dims), half = 0.5 * (hi - lo), normal(face.normal);
  return static_cast<float>(glm::dot(normal, middle) + static_cast<double>(face.offset) -
                            glm::dot(glm::abs(normal), half));
}

}  // namespace kiln
