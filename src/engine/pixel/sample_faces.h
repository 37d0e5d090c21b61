// Faces that end or light samples: the faces of the clip region, and the border of the volume.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "grid/coords.h"
#include "scene/clip_region.h"

namespace kiln {

/// A plane in a level's index space, in the form that kernels need. Points p with normal·p + offset >= 0 are inside.
/// unit: voxels from RaySampling's anchor.
struct SampleFace {
  glm::vec3 normal;  // length: 1
  float offset = 0;
  float voxel = 0;    // extent of a voxel's cube along the normal
  glm::vec3 slope;    // the normal, as long as a gradient of a direction
  bool cuts = false;  // samples end at the face; the border of the volume only lights them
  bool open = false;  // points on the face are outside
};

/// Returns the faces of a level. `slope`: length of a gradient that has a direction.
std::vector<SampleFace> sampleFaces(const ClipRegion& clip, const Extent3& dims, float slope);

/// Least distance from the face to the voxels' cubes inside the face, along its normal; below 0 if they reach across.
/// unit: voxels.
float leastInside(const SampleFace& face, const VoxelBox& voxels, const Extent3& dims);

}  // namespace kiln
