// Composites the slabs of several volumes on pixels' rays, from the nearest to the farthest. One implementation in
// Highway for every instruction set, as in engine/pixel/cast_cell.h.
#pragma once

#include "engine/pixel/ray_slabs.h"
#include "engine/pixel/slab_sums.h"
#include "engine/shared/tile_pixels.h"
#include "occlusion/visibility.h"

namespace kiln {

/// Adds the sums behind what the tile's pixels hold. A pixel that reaches `opaque_at` is divided by its alpha, set to
/// an alpha of one, and closed in `visibility`. requires: the sums are of `tile.rect` and of a zone of `rays`.
void compositeSlabs(const SlabSums& sums, const SlabZone& zone, const RaySlabs& rays, const TilePixels& tile,
                    float opaque_at, Visibility& visibility);

}  // namespace kiln
