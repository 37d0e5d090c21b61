// Pyramid levels that a frame may draw: projection, clip region and size of each level.
// Method (voxel engine; for the pixel engine see engine/shared/slab_grid.cpp). A region is drawn at the coarsest level
// whose voxels are at most a pixel at their nearest point, hence at least half a pixel there; level 0 if all are
// larger. Only axes that a level has halved count: along other axes the level is as fine as level 0.
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
  /// Holds only `level` if given, otherwise all levels of the volume. requires: 0 <= level < levels of the volume.
  /// throws: Error kUsage if the region of `clipping` contains no voxel.
  FrameLevels(const Manifest& volume, std::optional<int> level, const View& view, ProjectedArea area,
              const Clipping& clipping = {});

  int finest() const { return finest_; }
  int coarsest() const { return finest_ + static_cast<int>(levels_.size()) - 1; }
  const Extent3& dims(int level) const { return at(level).dims; }
  const Projector& projector(int level) const { return at(level).projector; }
  const EndVoxels& endVoxels(int level) const { return at(level).ends; }
  const ClipRegion& clipRegion(int level) const { return at(level).clip; }

  /// Size of a voxel of `level` along each axis. unit: voxels of level 0.
  const Extent3& span(int level) const { return at(level).span; }
  /// Returns true if a frame may draw the voxels of `box` (of `level`): they are at most a pixel, or no finer level
  /// exists.
  bool fineEnough(int level, const VoxelBox& box) const;

 private:
  struct Level {
    Extent3 dims;
    Projector projector;
    EndVoxels ends;
    ClipRegion clip;
    Extent3 span;
    double edge;  // longest halved edge. unit: world
  };
  const Level& at(int level) const { return levels_[static_cast<std::size_t>(level - finest_)]; }

  int finest_ = 0;
  std::vector<Level> levels_;
};

}  // namespace kiln
