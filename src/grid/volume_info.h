// Facts about a volume beside its voxels, which a source states and a store keeps.
#pragma once

#include <glm/mat4x4.hpp>
#include <string>

#include "grid/coords.h"

namespace kiln {

/// How the values are meant, where the source says so: it chooses the default transfer function and the export.
enum class VolumeClass { kUnknown, kFog, kLevelSet, kLabels };

/// What an OpenVDB source said of its grid, so that an export gives it back.
struct VdbOrigin {
  std::string grid_name;
  /// The grid coordinate of voxel (0,0,0).
  VoxelCoord index_origin;
  /// From the grid's own coordinates to the world.
  glm::dmat4 world_from_grid{1.0};
};

}  // namespace kiln
