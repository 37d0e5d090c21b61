// The levels of a volume.
// Method. Each level has half the voxels of the finer level along the axes that are fine enough, down to a single
// brick.
// A coarse voxel covers two finer voxels along a halved axis, so its centre is shifted by half a fine voxel. Only the
// affine of the level holds this shift.
#pragma once

#include <vector>

#include "grid/geometry.h"

namespace kiln {

/// Number of voxels that become one voxel of the next level along each axis: 1 or 2. An axis is halved if its spacing
/// is below √2 times the smallest spacing. An axis of one voxel is never halved and does not count as the smallest. All
/// 1 if the level is a single voxel.
Extent3 halvingOf(const VolumeGeometry& fine);

/// The next coarser level. A coarse voxel at the end of an odd axis covers only one voxel along this axis.
VolumeGeometry coarserThan(const VolumeGeometry& fine);

/// Returns level 0 (`finest`) and all coarser levels, down to the first of a single brick; at most `most_levels`.
std::vector<VolumeGeometry> pyramidOf(const VolumeGeometry& finest, std::int64_t brick_size, int most_levels);

}  // namespace kiln
