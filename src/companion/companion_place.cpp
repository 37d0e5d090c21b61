#include "companion/companion_place.h"

#include <cmath>
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

std::int64_t nearestVoxel(double place) { return static_cast<std::int64_t>(std::floor(place + 0.5 + kHalfwaySlack)); }

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

VoxelBox CompanionPlace::Map::around(const VoxelBox& box, std::int64_t reach) const {
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
  const VoxelBox all{{nearestVoxel(lo.x) - reach, nearestVoxel(lo.y) - reach, nearestVoxel(lo.z) - reach},
                     {nearestVoxel(hi.x) + reach + 1, nearestVoxel(hi.y) + reach + 1, nearestVoxel(hi.z) + reach + 1}};
  return intersection(all, boxOf(dims));
}

}  // namespace kiln
