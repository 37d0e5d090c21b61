// Problem: give each rank a box of the volume with an equal share of the visible voxels (`--distribute bricks`).
// Method: bisect the longest axis so that both sides have their share of visible sub-bricks, until each rank has a box.
// Invariant: the boxes fill the volume and share no voxel.
#pragma once

#include <vector>

#include "engine/shared/classifier.h"
#include "store/store_reader.h"

namespace kiln {

/// Returns one box per rank, cut between bricks of level 0 along axes with two bricks or more. A brick weighs as much
/// as its sub-bricks that may be visible. cost: bricks times log(ranks). throws: Error kUsage for a volume with fewer
/// voxels than ranks.
std::vector<VoxelBox> boxesForRanks(const StoreReader& store, const TransferFunction& function, int ranks);

}  // namespace kiln
