// Traversal of one brick's min-max octree for one image tile, from the brick down to its cells, front to back. Every
// visible cell is splatted into the tile.
// Source: Lee and Ihm §2.4.
#pragma once

#include "engine/shared/draw_counts.h"
#include "engine/voxel/splat_cell.h"
#include "traverse/node_log.h"

namespace kiln {

/// Splats the brick `block` into a tile; overwrites `planes`, which serve as scratch memory. `log` may be null;
/// otherwise every tested node is added to it.
/// requires: `planes` has room for the tile.
/// thread: tiles of one brick may run in parallel, each with its own pixels and planes; with a log only one tile runs
/// at a time.
void walkTile(const SplatContext& context, const BrickBlock& block, const TileTarget& target, TilePlanes& planes,
              DrawCounts& counts, NodeLog* log) noexcept;

}  // namespace kiln
