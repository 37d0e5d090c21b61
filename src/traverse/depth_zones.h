// Selects bricks for engines that decide levels by depth: a brick is drawn if it reaches into a zone of the brick's
// level.
#pragma once

#include <vector>

#include "engine/brick_selection.h"
#include "engine/shared/slab_grid.h"
#include "traverse/frame_levels.h"

namespace kiln {

class DepthZones {
 public:
  /// unit: world, along the view.
  struct Depths {
    double near, far;
  };

  /// requires: `levels` contains the zones' levels and outlives the object.
  DepthZones(const FrameLevels& levels, std::vector<SlabZone> zones) : levels_(levels), zones_(std::move(zones)) {}
  DepthZones(const DepthZones&) = delete;
  DepthZones& operator=(const DepthZones&) = delete;

  /// Zones from the nearest to the farthest.
  const std::vector<SlabZone>& zones() const { return zones_; }
  /// Depths of the voxels' cubes.
  Depths depthsOf(int level, const VoxelBox& box) const { return depthsOf(levels_.projector(level), box); }
  static Depths depthsOf(const Projector& projector, const VoxelBox& box);
  /// Returns true if slabs of the zone may have samples at these depths, or a brick there may own samples of the zone.
  static bool reaches(const Depths& depths, const SlabZone& zone);
  /// Draws bricks that reach into a zone of their level. requires: the object outlives the result.
  ChooseLevel levelChoice() const;

 private:
  const FrameLevels& levels_;
  const std::vector<SlabZone> zones_;
};

}  // namespace kiln
