// `--lattice pixel` and `ray`: what of which level is drawn where. Samples of the pixel lattice are no more than a
// pixel apart everywhere and no less than 7/16 of one, where the volume has a level for it; on rays levels are the
// same. All is decided by depth, in zones of slabs (splat/slab_grid.h).
#pragma once

#include <memory>

#include "frame/depth_zones.h"
#include "frame/memory_pool.h"
#include "frame/zone_frames.h"
#include "splat/ray_slabs.h"

namespace kiln {

class PixelLattice {
 public:
  /// Sweeps squares of `sweep_px` pixels. requires: `levels` and `transfer_function` outlive this.
  PixelLattice(const Manifest& volume, const FrameLevels& levels, const View& view, const Sampling& sampling,
               const TransferFunction& transfer_function, const Shading& shading, float gradient_noise, int sweep_px);
  PixelLattice(const PixelLattice&) = delete;
  PixelLattice& operator=(const PixelLattice&) = delete;

  /// requires: this outlives the result.
  BrickWalk::Choice choice() const { return zones_.choice(); }
  /// Parts are sub-bricks (store/sub_bricks.h), in each zone of their level. requires: this outlives the result.
  BrickWalk::AnyPart anyPart() const;

  /// What of a brick may be seen in one zone.
  struct ZoneCells {
    const SlabFrame* frame;
    const RaySlabs* rays;  // null in the pixel lattice
    std::vector<SlabCell> cells;
  };
  /// Those of a brick, from near to far. requires: this outlives the result. thread: safe.
  std::vector<ZoneCells> cellsOf(const BrickBlock& block) const;
  /// Of all of them, at the most. unit: bytes.
  static std::uint64_t cellBytes(std::int64_t brick_size);

  /// Draws what the tile shows of what the brick owns. requires: `zones` are the brick's. thread: of one tile, bricks
  /// one after the other, from front to back.
  void drawTile(const BrickBlock& block, const std::vector<ZoneCells>& zones, const TilePixels& tile,
                Visibility& visibility, bool test_samples, float opaque_at, SplatCounts& counts);

  /// What its threads have needed so far. unit: bytes.
  std::uint64_t bytes() const { return pool_.bytes(); }

 private:
  const std::int64_t brick_size_;
  const int sweep_px_;
  SampleTable table_;
  DepthZones zones_;
  std::vector<std::unique_ptr<SlabFrame>> frames_;  // one a zone
  std::vector<RaySlabs> rays_;                      // the same, where samples are on rays
  MemoryPool<SweepMemory> pool_;
};

}  // namespace kiln
