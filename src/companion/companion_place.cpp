#include "companion/companion_place.h"

#include <glm/matrix.hpp>

namespace kiln {
namespace {

// A voxel that is larger by less than this factor counts as equal: sizes of levels are rounded.
constexpr double kEqualSize = 1.01;

int levelFor(const VolumeGeometry& drawn, const Manifest& companion) {
  int out = 0;
  for (std::size_t level = 1; level < companion.levels.size(); ++level) {
    if (companion.levels[level].geometry.meanSpacing() > kEqualSize * drawn.meanSpacing()) break;
    out = static_cast<int>(level);
  }
  return out;
}

}  // namespace

CompanionPlace::CompanionPlace(const Manifest& drawn, const Manifest& companion) {
  for (const LevelInfo& level : drawn.levels) {
    Map map;
    map.level = levelFor(level.geometry, companion);
    const VolumeGeometry& geometry = companion.levels[static_cast<std::size_t>(map.level)].geometry;
    map.drawn = level.geometry.dims;
    map.dims = geometry.dims;
    const glm::dmat4 m = glm::inverse(geometry.world_from_index) * level.geometry.world_from_index;
    map.origin = glm::dvec3(m[3]);
    for (int axis = 0; axis < 3; ++axis) map.along[axis] = glm::dvec3(m[axis]);
    maps_.push_back(map);
  }
}

VoxelBox CompanionPlace::Map::around(const VoxelBox& box) const {
  glm::dvec3 lo(1e300), hi(-1e300);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 place =
        placeOf({(corner & 1) != 0 ? box.hi.x - 1 : box.lo.x, (corner & 2) != 0 ? box.hi.y - 1 : box.lo.y,
                 (corner & 4) != 0 ? box.hi.z - 1 : box.lo.z});
    lo = glm::min(lo, place);
    hi = glm::max(hi, place);
  }
  // Companions far away have no common voxel, whatever the distance.
  constexpr double kFar = 1e15;
  lo = glm::clamp(lo, -kFar, kFar), hi = glm::clamp(hi, -kFar, kFar);
  VoxelBox all{nearestVoxel(lo), nearestVoxel(hi)};
  for (int axis = 0; axis < 3; ++axis) ++all.hi[axis];
  return intersection(all, boxOf(dims));
}

std::int64_t CompanionPlace::Map::bricksFor(const VoxelBox& near, std::int64_t brick_size, std::int64_t beside) const {
  const VoxelBox one = dilated(coreBox(brickOf(middleVoxel(near), brick_size), brick_size, dims), beside);
  return intersection(one, near) == near ? 1 : coarseBox(near, brick_size).count();
}

}  // namespace kiln
