// `--lattice pixel`: what of which level is drawn where. A pixel's ray has a sample in the middle of each slab. All is
// decided by depth, in zones of slabs (engine/shared/slab_grid.h).
#pragma once

#include <memory>

#include "engine/pixel/ray_slabs.h"
#include "engine/pixel/zone_frames.h"
#include "engine/shared/draw_counts.h"
#include "traverse/depth_zones.h"

namespace kiln {

/// Voxels beside a brick that the test of a cut looks at: a sample lies across faces (SlabFrame::cutOff).
inline constexpr std::int64_t kCutGhosts = 1;

class PixelLattice {
 public:
  /// requires: `levels` and `transfer_function` outlive this.
  PixelLattice(const Manifest& volume, const FrameLevels& levels, const View& view, const Sampling& sampling,
               const TransferFunction& transfer_function, const Shading& shading, float gradient_noise);
  PixelLattice(const PixelLattice&) = delete;
  PixelLattice& operator=(const PixelLattice&) = delete;

  /// requires: this outlives the result.
  BrickWalk::Choice choice() const { return zones_.choice(); }
  /// Parts are sub-bricks (store/ranges/sub_bricks.h), in each zone of their level. requires: this outlives the result.
  BrickWalk::VisiblePart anyPart() const;

  /// What of a brick may be seen in one zone.
  struct ZoneCells {
    const SlabFrame* frame;
    const RaySlabs* rays;
    std::vector<SlabCell> cells;
  };
  /// Those of a brick, from near to far. requires: this outlives the result. thread: safe.
  std::vector<ZoneCells> cellsOf(const BrickBlock& block) const;
  /// Of all of them, at the most. unit: bytes.
  static std::uint64_t cellBytes(std::int64_t brick_size);

  /// Draws what the tile shows of what the brick owns. requires: `zones` are the brick's. thread: of one tile, bricks
  /// one after the other, from front to back.
  void drawTile(const BrickBlock& block, const std::vector<ZoneCells>& zones, const TilePixels& tile,
                Visibility& visibility, float opaque_at, DrawCounts& counts) const;

 private:
  const std::int64_t brick_size_;
  SampleTable table_;
  DepthZones zones_;
  std::vector<std::unique_ptr<SlabFrame>> frames_;  // one a zone
  std::vector<RaySlabs> rays_;                      // the same
};

}  // namespace kiln
