// Composites the slabs of several volumes on pixels' rays, front to back. README.md, equations (7) to (9). One Highway
// implementation for all instruction sets, as in engine/pixel/cast_rays_in_cell.h.
#pragma once

#include "engine/pixel/ray_sampling.h"
#include "engine/pixel/slab_sums.h"
#include "engine/shared/tile_pixels.h"
#include "occlusion/visibility.h"

namespace kiln {

/// Composites the sums behind the tile's pixels. At an alpha of `opacity_threshold` a pixel is divided by alpha, alpha
/// is set to 1, and the pixel is closed in `visibility`. `exact`: a volume shows surfaces or cut faces, and layers have
/// the places of their samples in a slab. requires: the sums cover `tile.rect` and a zone of `rays`.
void compositeSlabs(const SlabSums& sums, const SlabZone& zone, const RaySampling& rays, const TilePixels& tile,
                    float opacity_threshold, bool exact, Visibility& visibility);

}  // namespace kiln
