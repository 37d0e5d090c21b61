// Positions of a drawn volume's voxels in a companion.
// A level of the drawn volume reads the coarsest level of the companion whose voxels are at most as large.
#pragma once

#include <cmath>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "grid/coords.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// A point between voxels of equal distance belongs to the voxel with the greater index. Positions this much before
/// such a point count as the point, so that rounding of the affine decides nothing. unit: voxels.
inline constexpr double kHalfwaySlack = 1.0 / (1 << 16);

inline VoxelCoord nearestVoxel(const glm::dvec3& place) {
  const auto index = [](double at) { return static_cast<std::int64_t>(std::floor(at + 0.5 + kHalfwaySlack)); };
  return {index(place.x), index(place.y), index(place.z)};
}

inline VoxelCoord middleVoxel(const VoxelBox& box) {
  return {(box.lo.x + box.hi.x) / 2, (box.lo.y + box.hi.y) / 2, (box.lo.z + box.hi.z) / 2};
}

class CompanionPlace {
 public:
  /// The map from a level of the drawn volume into the level of the companion that the level reads.
  struct Map {
    int level = 0;  // level of the companion
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
    /// Box around the companion's voxels that are nearest to voxels of `box`, clipped at the companion. requires: not
    /// empty.
    VoxelBox around(const VoxelBox& box) const;
    /// Number of bricks that hold the companion's voxels `near`: one if the brick in the middle holds all of them with
    /// `beside` voxels around its core.
    std::int64_t bricksFor(const VoxelBox& near, std::int64_t brick_size, std::int64_t beside) const;
  };

  /// requires: both volumes are placed in one world.
  CompanionPlace(const Manifest& drawn, const Manifest& companion);
  const Map& of(int level) const { return maps_[static_cast<std::size_t>(level)]; }

 private:
  std::vector<Map> maps_;  // one per level of the drawn volume
};

}  // namespace kiln
