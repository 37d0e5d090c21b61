// Where the voxels of a drawn volume lie in a companion.
// A level of the drawn volume reads the coarsest level of the companion whose voxels are at most as large.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "grid/coords.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// A point between voxels of equal distance belongs to the voxel with the greater index. Positions this much before
/// such a point count as the point, so that rounding of the affine decides nothing. unit: voxels.
inline constexpr double kHalfwaySlack = 1.0 / (1 << 16);

/// Index of the nearest voxel along an axis.
std::int64_t nearestVoxel(double place);

class CompanionPlace {
 public:
  /// The map from a level of the drawn volume into the level of the companion that the level reads.
  struct Map {
    int level = 0;  // of the companion
    Extent3 drawn;  // voxels of the drawn volume's level
    Extent3 dims;   // voxels of the companion's level
    glm::dvec3 origin, along[3];

    /// Position of a voxel in the companion's index space, in this order of operations.
    glm::dvec3 placeOf(const VoxelCoord& voxel) const {
      return ((origin + static_cast<double>(voxel.z) * along[2]) + static_cast<double>(voxel.y) * along[1]) +
             static_cast<double>(voxel.x) * along[0];
    }
    /// True if each axis of the drawn volume runs along the companion's axis of the same number.
    bool straight() const {
      return along[0].y == 0 && along[0].z == 0 && along[1].x == 0 && along[1].z == 0 && along[2].x == 0 &&
             along[2].y == 0;
    }
    /// Box around the companion's voxels that are nearest to voxels of `box`, and `reach` voxels more; clipped at the
    /// companion. requires: not empty.
    VoxelBox around(const VoxelBox& box, std::int64_t reach) const;
  };

  /// requires: both volumes are placed in one world.
  CompanionPlace(const Manifest& drawn, const Manifest& companion);
  const Map& of(int level) const { return maps_[static_cast<std::size_t>(level)]; }

 private:
  std::vector<Map> maps_;  // one per level of the drawn volume
};

}  // namespace kiln
