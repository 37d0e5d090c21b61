// The kernel of `--lattice pixel`: one brick in one tile, slab after slab, front to back. Cells that may be seen are
// cut into units when their first slab's turn comes, units are refined to samples no more than a pixel apart, and each
// sample waits for its slab, is tested for visibility with its own footprint against all that is in front of it, and
// is added to the slab's sheet, which is then laid behind what the image holds (DESIGN §6).
//
// A brick writes the pixels of slabs that it owns: those whose place in space (the pixel's centre, the slab's middle)
// is in the brick. To them it adds the samples of its apron, so that no pixel of a slab is the sum of two bricks. Or
// all bricks of several volumes that reach into a zone of slabs are swept together, each with its own samples.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "splat/slab_frame.h"

namespace kiln {

/// What a sweep needs for a time; made once for each thread and kept.
class SweepMemory {
 public:
  SweepMemory();
  ~SweepMemory();
  /// unit: bytes.
  std::size_t bytes() const;
  struct Parts;
  Parts& parts() { return *parts_; }

 private:
  std::unique_ptr<Parts> parts_;
};

/// Draws what the brick owns of the zone's slabs in this tile. requires: `block` of the zone's level; `cells` are those
/// of its interesting cells that touch the tile. Of `test_samples` and `opaque_at` SplatFrame says what they are.
void sweepSlabs(const SlabFrame& frame, const BrickBlock& block, std::span<const SlabCell* const> cells,
                const TilePixels& tile, Visibility& visibility, bool test_samples, float opaque_at, SweepMemory& memory,
                SplatCounts& counts);

/// A cell of a brick of one of several volumes.
struct SweptCell {
  const SlabCell* cell;
  const BrickBlock* block;
  std::size_t volume;
};

/// Draws all of a zone in this tile: what several volumes put into each slab is joined (splat/join_volumes.h) before it
/// is laid. shape: a frame and counts for each volume; a frame may be null where no cell is of it. requires: frames of
/// the same slabs and taps whose bricks are not owned; `cells` are all interesting ones of all bricks of the zone that
/// touch the tile; at most kMostVolumes volumes.
void sweepTogether(std::span<const SlabFrame* const> frames, std::span<const SweptCell> cells, const TilePixels& tile,
                   Visibility& visibility, bool test_samples, float opaque_at, SweepMemory& memory,
                   std::span<SplatCounts> counts);

}  // namespace kiln
