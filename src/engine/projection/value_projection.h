// `--mode mip|minip|average`: selects the bricks to project, their order, and the bricks that can change no pixel.
// Method. Levels are chosen as in the pixel engine. For an extremum any order is correct: constant bricks come first,
// then bricks by the greatest value of their own voxels, so that pixels soon hold values that hide the rest. A mean
// takes all bricks, front to back.
#pragma once

#include "engine/projection/project_brick.h"
#include "engine/shared/draw_counts.h"
#include "traverse/depth_zones.h"

namespace kiln {

class ValueProjection {
 public:
  /// With `culls`, bricks, tiles and cells that can change no pixel are skipped. requires: `store` and `levels` outlive
  /// the object, `levels` belongs to `store`; a mode that projects values.
  ValueProjection(const StoreReader& store, const FrameLevels& levels, const View& view, std::optional<int> level,
                  Mode mode, bool culls);

  /// Distance beyond a brick's voxels that its samples reach. unit: voxels.
  static constexpr std::int64_t kGhosts = 1;
  /// requires: the object outlives the results.
  BrickWalk::Choice choice() const { return zones_.choice(); }
  BrickWalk::VisiblePart anyPart() const;

  /// Pixels without values; pixels that no sample can reach are marked (leaveOut).
  ProjectedValues begin(const PixelRect& pixels) const;
  /// Returns the bricks in drawing order. `front_to_back` is the order of the walk.
  std::vector<BrickInView> ordered(std::vector<BrickInView> front_to_back) const;
  /// Returns true if the brick can change no pixel.
  bool hidden(const BrickInView& brick, const ProjectedValues& values) const;

  /// Projects the brick into the tiles in parallel; `block` is null for a constant brick.
  DrawCounts draw(const BrickInView& brick, const BrickBlock* block, const std::vector<PixelRect>& tiles,
                  ProjectedValues& values) const;

 private:
  const BrickEntry& entryOf(const BrickInView& brick) const { return store_.index().at(brick.key); }
  VoxelBox coreOf(const BrickKey& key) const;
  /// End of level 0 in the index space of `level`.
  glm::dvec3 endOf(int level) const;
  /// Bounds of a brick's samples.
  static ValueRange rangeOf(const BrickEntry& entry);
  void drawTile(const BrickInView& brick, const BrickBlock* block, double bound, const PixelRect& rect,
                ProjectedValues& values, DrawCounts& counts) const;

  const StoreReader& store_;
  const FrameLevels& levels_;
  const Mode mode_;
  const bool culls_;
  DepthZones zones_;
  std::vector<RayFrame> frames_;  // one for each level, the finest first
};

}  // namespace kiln
