// Composites the slabs of several volumes on pixels' rays, front to back. README.md, equations (7) to (9). One Highway
// implementation for all instruction sets, as in engine/pixel/cast_cell.h.
#pragma once

#include "engine/pixel/ray_slabs.h"
#include "engine/pixel/slab_sums.h"
#include "engine/shared/tile_pixels.h"
#include "occlusion/visibility.h"

namespace kiln {

/// Composites the sums behind the tile's pixels. At an alpha of `opaque_at` a pixel is divided by alpha, alpha is set
/// to 1, and the pixel is closed in `visibility`. requires: the sums cover `tile.rect` and a zone of `rays`.
void compositeSlabs(const SlabSums& sums, const SlabZone& zone, const RaySlabs& rays, const TilePixels& tile,
                    float opaque_at, Visibility& visibility);

}  // namespace kiln
