// Which voxels each rank draws where ranks share bricks: boxes that fill the volume, made by cutting it again and again
// so that each side has its share of what the transfer function shows.
#pragma once

#include <vector>

#include "engine/shared/classifier.h"
#include "store/store_reader.h"

namespace kiln {

/// One box a rank, cut between bricks of level 0 where there are two of them along an axis. A brick counts as many
/// voxels as its sub-bricks have that may show something. cost: bricks times the logarithm of the ranks. throws: Error
/// kUsage where the volume has too few voxels.
std::vector<VoxelBox> boxesForRanks(const StoreReader& store, const TransferFunction& function, int ranks);

}  // namespace kiln
