// Ranges of the values interpolated linearly in each cell of a brick and of its apron: the least and greatest value of
// the cell's voxels and their neighbours. A cell whose range is transparent is not drawn.
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
  /// shape: `voxels` covers `extent`, x fastest; `edge` cells along each axis of the core, from the core's first voxel
  /// on.
  /// cost: 1 ms for 128³ voxels.
  CellSupports(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& extent, const VoxelCoord& core,
               int edge);

  /// Cells along an axis: those of the core, plus one on either side.
  int edge() const { return edge_; }
  /// Range of a cell; cell (1, 1, 1) starts at the core's first voxel. Empty for a cell without voxels, or with only
  /// NaN.
  const ValueRange& at(int x, int y, int z) const {
    return ranges_[static_cast<std::size_t>((z * edge_ + y) * edge_ + x)];
  }
  /// Makes the range of a cell empty: nothing of the cell is shown.
  void hide(int x, int y, int z) { ranges_[static_cast<std::size_t>((z * edge_ + y) * edge_ + x)] = {}; }
  std::size_t bytes() const { return bytesFor(edge_ - 2); }
  /// Memory for a brick of `edge` cells. unit: bytes.
  static std::size_t bytesFor(std::int64_t edge) {
    return static_cast<std::size_t>((edge + 2) * (edge + 2) * (edge + 2)) * sizeof(ValueRange);
  }
  /// Upper bound of the working memory for a brick. unit: bytes.
  static std::size_t scratchBytes(std::int64_t brick_size, std::int64_t apron, VoxelType type) {
    return boxRangesScratch(brick_size + 2 * apron, brick_size / kCellSize + 2, kCellSize + 2, type);
  }

 private:
  int edge_ = 0;
  std::vector<ValueRange> ranges_;
};

}  // namespace kiln
