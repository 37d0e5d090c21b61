// The levels of the pyramid that a frame may draw: where the lattice of each falls on the image, and which is right for
// a region of `--lattice voxel` (of the pixel lattice it is said in engine/shared/slab_grid.cpp). That is the coarsest
// whose voxels are no larger than a pixel where they are nearest, so that they are no smaller than half a pixel there;
// level 0 where all are larger. Only axes that a level has halved are asked: along the others it is as fine as level 0.
#pragma once

#include <optional>
#include <vector>

#include "engine/shared/end_voxels.h"
#include "engine/shared/projector.h"
#include "scene/clip_region.h"
#include "store/manifest/manifest.h"

namespace kiln {

class FrameLevels {
 public:
  /// One level where `level` names it, else all of the volume's. requires: 0 <= level < levels of the volume. throws:
  /// Error kUsage where the clipping's region holds no voxel.
  FrameLevels(const Manifest& volume, std::optional<int> level, const View& view, ProjectedArea area,
              const Clipping& clipping = {});

  int finest() const { return finest_; }
  int coarsest() const { return finest_ + static_cast<int>(levels_.size()) - 1; }
  const Extent3& dims(int level) const { return at(level).dims; }
  const Projector& projector(int level) const { return at(level).projector; }
  const EndVoxels& endVoxels(int level) const { return at(level).ends; }
  const ClipRegion& clipRegion(int level) const { return at(level).clip; }

  /// How many voxels of level 0 a voxel of `level` spans along each axis.
  const Extent3& span(int level) const { return at(level).span; }
  /// Whether a frame may draw the voxels of `box` (of `level`) as they are: they are at most a pixel, or there are none
  /// finer.
  bool fineEnough(int level, const VoxelBox& box) const;

 private:
  struct Level {
    Extent3 dims;
    Projector projector;
    EndVoxels ends;
    ClipRegion clip;
    Extent3 span;
    double edge;  // the longest of those that were halved. unit: world
  };
  const Level& at(int level) const { return levels_[static_cast<std::size_t>(level - finest_)]; }

  int finest_ = 0;
  std::vector<Level> levels_;
};

}  // namespace kiln
