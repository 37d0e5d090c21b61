#include "store/brick_ranges.h"

namespace kiln {
namespace {

BrickRanges rangesIn(const VoxelBox& core, int edge, VoxelType type, std::span<const std::byte> voxels,
                     const VoxelBox& box) {
  BrickRanges out;
  out.cells = cellRanges(voxels, type, box, core, edge);
  for (const ValueRange& cell : out.cells) out.core.include(cell);
  out.support = rangeOf(voxels, type, box, box);
  return out;
}

}  // namespace

BrickRanges rangesOf(const BrickFrame& frame, std::span<const std::byte> voxels) {
  const int edge = static_cast<int>(frame.brick_size / kCellSize);
  return rangesIn(frame.core(), edge, frame.type, voxels, frame.stored());
}

// What the extent has beyond the volume repeats voxels of it, and changes no range.
BrickRanges rangesOf(const BrickBlock& block) {
  return rangesIn(block.core, block.octree.edge(0), block.type, block.voxels, block.extent);
}

}  // namespace kiln
