// The lower part of the one octree, for one tile of the image: from a brick down to its cells, front to back, each cell
// splatted into the tile.
#pragma once

#include "engine/shared/draw_counts.h"
#include "engine/voxel/splat_cell.h"
#include "traverse/node_log.h"

namespace kiln {

/// Splats by way of `planes`, whoever's pixels they held before. requires: `planes` has room for the tile. thread:
/// tiles of one brick run at the same time; each touches its own pixels and planes only. `log` may be null; not null,
/// it is told of every node asked about, and one tile runs at a time.
void walkTile(const SplatContext& frame, const BrickBlock& block, const TilePixels& tile, TilePlanes& planes,
              DrawCounts& counts, NodeLog* log) noexcept;

}  // namespace kiln
