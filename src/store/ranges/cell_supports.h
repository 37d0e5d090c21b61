// What the values that are linearly interpolated in a cell range over: the least and greatest of its voxels and those
// next to it, for each cell of a brick and of the apron around it. Decides whether a cell is drawn at all.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "grid/coords.h"
#include "grid/value_range.h"
#include "grid/voxel_type.h"
#include "store/ranges/box_ranges.h"
#include "store/ranges/minmax_octree.h"

namespace kiln {

class CellSupports {
 public:
  CellSupports() = default;
  /// shape: `voxels` covers `extent`, x fastest; `edge` cells along each axis of the core, from its first voxel on.
  /// cost: 1 ms for 128³ voxels.
  CellSupports(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& extent, const VoxelCoord& core,
               int edge);

  /// Cells along an axis: the core's and one on either side.
  int edge() const { return edge_; }
  /// Cell (1, 1, 1) begins at the core's first voxel. Empty where there is no voxel, or none but NaN.
  const ValueRange& at(int x, int y, int z) const {
    return ranges_[static_cast<std::size_t>((z * edge_ + y) * edge_ + x)];
  }
  std::size_t bytes() const { return bytesFor(edge_ - 2); }
  /// For a brick of `edge` cells. unit: bytes.
  static std::size_t bytesFor(std::int64_t edge) {
    return static_cast<std::size_t>((edge + 2) * (edge + 2) * (edge + 2)) * sizeof(ValueRange);
  }
  /// The most that computing those of a brick holds beside its result. unit: bytes.
  static std::size_t scratchBytes(std::int64_t brick_size, std::int64_t apron, VoxelType type) {
    return boxRangesScratch(brick_size + 2 * apron, brick_size / kCellSize + 2, kCellSize + 2, type);
  }

 private:
  int edge_ = 0;
  std::vector<ValueRange> ranges_;
};

}  // namespace kiln
