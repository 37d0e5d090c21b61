// The lower part of the one octree, for one tile of the image: from a brick down to its cells, front to back, each cell
// splatted into the tile.
#pragma once

#include "splat/splat_cell.h"

namespace kiln {

/// thread: tiles of one brick run at the same time; each touches its own pixels only.
void walkTile(const SplatFrame& frame, const BrickBlock& block, const TilePixels& tile, SplatCounts& counts) noexcept;

}  // namespace kiln
