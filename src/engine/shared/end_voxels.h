// Last voxels of a coarser level, which the volume fills only in part.
#pragma once

#include <glm/vec3.hpp>

#include "grid/coords.h"

namespace kiln {

/// Fraction of the last voxel that the volume fills, per axis. Below 1 if the volume's extent is no multiple of a
/// coarse voxel; the voxel's material is scaled by the fraction.
struct EndVoxels {
  VoxelCoord last{-1, -1, -1};
  glm::dvec3 part{1};
  bool any() const { return part != glm::dvec3(1); }
  double partOf(const VoxelCoord& v) const {
    return (v.x == last.x ? part.x : 1) * (v.y == last.y ? part.y : 1) * (v.z == last.z ? part.z : 1);
  }
};

}  // namespace kiln
