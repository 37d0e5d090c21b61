// Along the rays of the pixel lattice: the samples where pixels' rays meet slabs, cell after cell of a brick in one
// tile. Each sample is in one cell and fills its pixel of its slab by itself. Cells come front to back, so that a pixel
// has its samples in the order of their depths, and nothing waits. What a cell shows is the kernel's
// (engine/pixel/cast_cell.h).
#pragma once

#include <span>

#include "engine/pixel/ray_slabs.h"
#include "engine/pixel/slab_frame.h"
#include "engine/pixel/slab_sums.h"
#include "engine/shared/draw_counts.h"

namespace kiln {

/// Adds what the cells show to the tile. requires: all in front of them, as pixels' rays see it, has been added; `rays`
/// and `frame` are of one zone, `block` of its level; `cells` are its interesting ones, front to back; the tile
/// is at most kSquareEdge pixels wide and high. Of `opaque_at` SplatContext says what it is.
void castCells(const RaySlabs& rays, const SlabFrame& frame, const BrickBlock& block, std::span<const SlabCell> cells,
               const TilePixels& tile, Visibility& visibility, float opaque_at, DrawCounts& counts);

/// Adds what the cells of one of several volumes show to the sums, for compositeSlabs. Closed pixels of the tile get
/// nothing; the tile does not change. requires: as castCells, but for the order of cells; the sums are of `tile.rect`.
void sumCells(const RaySlabs& rays, const SlabFrame& frame, const BrickBlock& block, std::span<const SlabCell> cells,
              const TilePixels& tile, Visibility& visibility, SlabSums& sums, DrawCounts& counts);

}  // namespace kiln
