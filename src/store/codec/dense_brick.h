// A decoded brick made of voxels in memory: its edges, octree and supports.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "store/codec/brick_codec.h"

namespace kiln {

/// Returns a brick whose voxels have no values yet.
BrickBlock emptyBlock(const BrickDesc& brick);
/// Fills voxels of the extent outside the volume with the nearest voxel of `stored`.
void clampEdges(BrickBlock& block, const VoxelBox& stored);
/// Returns the supports of a block's cells.
CellSupports supportsOf(const BrickBlock& block);

/// Returns the brick that decodeBrick returns for the file of these voxels. shape: `voxels` covers brick.stored(), x
/// fastest, in brick.type; `cells` as in BrickRanges. cost: about 2 ms for 128³ bytes.
BrickBlock denseBrick(const BrickDesc& brick, std::span<const std::byte> voxels, std::vector<ValueRange> cells);
/// Upper bound of the memory of denseBrick, its arguments and result included. unit: bytes.
std::size_t denseBytes(const BrickDesc& brick);

}  // namespace kiln
