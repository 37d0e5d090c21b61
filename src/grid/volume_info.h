// Properties of a volume beside its voxels, read from a source and kept in a store.
#pragma once

#include <glm/mat4x4.hpp>
#include <string>

#include "grid/coords.h"

namespace kiln {

/// Meaning of the values, if the source declares it; selects the default transfer function and the export type.
enum class VolumeClass { kUnknown, kFog, kLevelSet, kLabels };

/// Name and coordinates of the source's OpenVDB grid, restored by an export.
struct VdbOrigin {
  std::string grid_name;
  /// Grid coordinate of voxel (0,0,0).
  VoxelCoord index_origin;
  /// Maps grid coordinates to the world.
  glm::dmat4 world_from_grid{1.0};
};

}  // namespace kiln
