// `--mode mip|minip|average`: which bricks of which level project their values, in which order, and which have nothing
// that their pixels do not hold already. Levels are those of the pixel lattice. An extremum does not ask for an order:
// bricks without a file come first, then those that have the most in their own voxels, so that pixels soon hold what
// hides the rest. A mean takes them all, front to back.
#pragma once

#include "engine/projection/project_brick.h"
#include "engine/shared/draw_counts.h"
#include "traverse/depth_zones.h"

namespace kiln {

class ValueProjection {
 public:
  /// With `culls`, bricks, tiles and cells that can change nothing are left out. requires: `store` and `levels`, which
  /// are of this store, outlive this; a mode that projects values.
  ValueProjection(const StoreReader& store, const FrameLevels& levels, const View& view, std::optional<int> level,
                  Mode mode, bool culls);

  /// How far beyond a brick's voxels the walk has to look. unit: voxels.
  static constexpr std::int64_t kGhosts = 1;
  /// requires: this outlives the results.
  BrickWalk::Choice choice() const { return zones_.choice(); }
  BrickWalk::VisiblePart anyPart() const;

  /// Pixels without a value, those that no sample lies behind left out.
  ProjectedValues begin(const PixelRect& pixels) const;
  /// The bricks in the order in which they are drawn. `front_to_back` is that of the walk.
  std::vector<BrickInView> ordered(std::vector<BrickInView> front_to_back) const;
  /// Whether the brick can change no pixel.
  bool hidden(const BrickInView& brick, const ProjectedValues& values) const;

  /// Takes the brick's values into the tiles, which are drawn in parallel; `block` is null where it is constant.
  DrawCounts draw(const BrickInView& brick, const BrickBlock* block, const std::vector<PixelRect>& tiles,
                  ProjectedValues& values) const;

 private:
  const BrickEntry& entryOf(const BrickInView& brick) const { return store_.index().at(brick.key); }
  VoxelBox coreOf(const BrickKey& key) const;
  /// Where level 0 ends in the index space of `level`.
  glm::dvec3 endOf(int level) const;
  /// The range of what a brick's samples may be.
  static ValueRange rangeOf(const BrickEntry& entry);
  void drawTile(const BrickInView& brick, const BrickBlock* block, double bound, const PixelRect& rect,
                ProjectedValues& values, DrawCounts& counts) const;

  const StoreReader& store_;
  const FrameLevels& levels_;
  const Mode mode_;
  const bool culls_;
  DepthZones zones_;
  std::vector<RayFrame> frames_;  // one a level, the finest first
};

}  // namespace kiln
