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

/// Returns the brick that decodeBrick returns for the file of these voxels. shape: `voxels` covers `box`, x fastest, in
/// brick.type; `cells` as in BrickRanges. requires: brick.stored() is the part of `box` in the brick's extent. cost:
/// about 2 ms for 128³ bytes.
BrickBlock denseBrick(const BrickDesc& brick, std::span<const std::byte> voxels, const VoxelBox& box,
                      std::vector<ValueRange> cells);
/// Upper bound of the memory of denseBrick, its arguments for a box of brick.stored(), and its result. unit: bytes.
std::size_t denseBytes(const BrickDesc& brick);

}  // namespace kiln
