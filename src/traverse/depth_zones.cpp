#include "traverse/depth_zones.h"

#include <algorithm>
#include <limits>

namespace kiln {

DepthZones::Depths DepthZones::depthsOf(const Projector& projector, const VoxelBox& box) {
  Depths out{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (int corner = 0; corner < 8; ++corner) {
    glm::dvec3 at;
    for (int axis = 0; axis < 3; ++axis)
      at[axis] = static_cast<double>((corner >> axis & 1) != 0 ? box.hi[axis] : box.lo[axis]) - 0.5;
    const double z = projector.viewOfIndex(at).z;
    out.near = std::min(out.near, z);
    out.far = std::max(out.far, z);
  }
  return out;
}

// Allows two slabs on either side: samples extend in depth, and the outermost bricks own samples beyond their faces.
bool DepthZones::reaches(const Depths& depths, const SlabZone& zone) {
  return depths.far >= zone.overlapNear() - 2 * zone.thickness && depths.near <= zone.far + 2 * zone.thickness;
}

ChooseLevel DepthZones::levelChoice() const {
  return [this](int level, const VoxelBox& box) {
    const Depths depths = depthsOf(level, box);
    BrickUse use;
    for (const SlabZone& zone : zones_) {
      if (!reaches(depths, zone)) continue;
      use.itself = use.itself || zone.level == level;
      use.finer = use.finer || zone.level < level;
    }
    return use;
  };
}

}  // namespace kiln
