// The levels of a volume: each has half the voxels of the one below it along the axes that are fine enough, down to one
// brick. A voxel of a coarser level covers the two voxels below it along a halved axis, so its centre lies half a fine
// voxel further in: that is in the affine, and nowhere else.
#pragma once

#include <vector>

#include "grid/geometry.h"

namespace kiln {

/// How many voxels of a level become one of the next, along each axis: 1 or 2. Halved are the axes whose spacing is
/// below √2 times the smallest; an axis of one voxel is never halved and does not count as the smallest. All 1 where
/// the level is a single voxel.
Extent3 halvingOf(const VolumeGeometry& fine);

/// The next coarser level. A voxel at the end of an odd axis covers one voxel only.
VolumeGeometry coarserThan(const VolumeGeometry& fine);

/// Level 0 (`finest` itself) and the coarser ones, up to the first that is a single brick; at most `most_levels`.
std::vector<VolumeGeometry> pyramidOf(const VolumeGeometry& finest, std::int64_t brick_size, int most_levels);

}  // namespace kiln
