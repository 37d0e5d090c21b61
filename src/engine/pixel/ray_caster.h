// Draws the cells of a brick into a tile: samples at the intersections of pixels' rays and slabs, cell after cell.
// Method. Each sample belongs to a single cell and contributes to a single pixel. Cells come front to back, so that a
// pixel
// receives samples in order of depth and no state is kept between cells. The kernel is
// engine/pixel/cast_rays_in_cell.h.
#pragma once

#include <span>

#include "engine/pixel/ray_sampling.h"
#include "engine/pixel/slab_context.h"
#include "engine/pixel/slab_sums.h"
#include "engine/shared/draw_counts.h"

namespace kiln {

/// Draws the cells into the tile. A pixel whose alpha reaches `opacity_threshold` is closed. requires: everything in
/// front of the cells, along pixels' rays, has been drawn; `rays` and `context` belong to one zone, `block` to its
/// level; `cells` are the block's visible cells, front to back.
void castRays(const RaySampling& rays, const SlabContext& context, const BrickBlock& block,
              std::span<const SlabCell> cells, const TilePixels& tile, Visibility& visibility, float opacity_threshold,
              DrawCounts& counts);

/// Adds the cells of one of several volumes to the sums for compositeSlabs. Closed pixels of the tile get no light; the
/// tile does not change. requires: as castRays, except the order of cells; the sums cover `tile.rect`, of at most
/// kSquareEdge pixels an edge.
void sumCells(const RaySampling& rays, const SlabContext& context, const BrickBlock& block,
              std::span<const SlabCell> cells, const TilePixels& tile, Visibility& visibility, SlabSums& sums,
              DrawCounts& counts);

}  // namespace kiln
