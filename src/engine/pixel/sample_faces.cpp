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

std::vector<SampleFace> sampleFaces(const ClipRegion& clip, const Extent3& dims, const EndVoxels& ends, float slope) {
  std::vector<SampleFace> out;
  const auto add = [&](const glm::dvec4& half_space, bool cuts, bool open) {
    const double length = glm::length(glm::dvec3(half_space));
    const glm::dvec3 normal = glm::dvec3(half_space) / length, size = glm::abs(normal);
    out.push_back({glm::vec3(normal), static_cast<float>(half_space.w / length + glm::dot(normal, anchorOf(dims))),
                   static_cast<float>(size.x + size.y + size.z), slope * glm::vec3(normal), cuts, open});
  };
  const std::vector<glm::dvec4> cuts = clip.halfSpaces();
  for (std::size_t i = 0; i < cuts.size(); ++i) add(cuts[i], true, clip.open(i));
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec4 border(0, 0, 0, 0.5);
    border[axis] = 1;
    add(border, false, false);
    border[axis] = -1, border.w = RaySampling::volumeEnd(axis, dims, ends);
    add(border, false, false);
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
