#include "store/codec/brick_ranges.h"

namespace kiln {
namespace {

BrickRanges rangesIn(const VoxelBox& core, std::int64_t brick_size, VoxelType type, std::span<const std::byte> voxels,
                     const VoxelBox& box) {
  BrickRanges out;
  out.cells = cellRanges(voxels, type, box, core, static_cast<int>(brick_size / kCellSize));
  for (const ValueRange& cell : out.cells) out.core.include(cell);
  out.sub_bricks = subBrickRanges(voxels, type, box, core, brick_size, subBricksOf(brick_size));
  for (const ValueRange& sub_brick : out.sub_bricks) out.support.include(sub_brick);
  return out;
}

}  // namespace

BrickRanges rangesOf(const BrickDesc& frame, std::span<const std::byte> voxels) {
  return rangesIn(frame.core(), frame.brick_size, frame.type, voxels, frame.stored());
}

// Voxels of the extent beyond the volume repeat voxels of the volume and change no range.
BrickRanges rangesOf(const BrickBlock& block) {
  return rangesIn(block.core, block.octree.edge(0) * kCellSize, block.type, block.voxels, block.extent);
}

}  // namespace kiln
