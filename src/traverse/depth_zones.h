// Which bricks a frame draws whose levels are decided by depth: those that reach into a zone of their level.
#pragma once

#include <vector>

#include "engine/shared/slab_grid.h"
#include "traverse/brick_walk.h"

namespace kiln {

class DepthZones {
 public:
  /// unit: world, along the view.
  struct Depths {
    double near, far;
  };

  /// requires: `levels`, which has the zones' levels, outlives this.
  DepthZones(const FrameLevels& levels, std::vector<SlabZone> zones) : levels_(levels), zones_(std::move(zones)) {}
  DepthZones(const DepthZones&) = delete;
  DepthZones& operator=(const DepthZones&) = delete;

  /// From the nearest to the farthest.
  const std::vector<SlabZone>& zones() const { return zones_; }
  /// Of the voxels' cubes.
  Depths depthsOf(int level, const VoxelBox& box) const { return depthsOf(levels_.projector(level), box); }
  static Depths depthsOf(const Projector& projector, const VoxelBox& box);
  /// Whether slabs of the zone may take something from there, or be owned there.
  static bool reaches(const Depths& depths, const SlabZone& zone);
  /// A brick is drawn where it reaches into a zone of its level. requires: this outlives the result.
  BrickWalk::Choice choice() const;

 private:
  const FrameLevels& levels_;
  const std::vector<SlabZone> zones_;
};

}  // namespace kiln
