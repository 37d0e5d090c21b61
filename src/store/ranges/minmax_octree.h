// Min-max octree of a brick. The leaves are cells of 8³ voxels; each node holds the least and greatest value below. The
// octree is a subtree of the store's octree, whose upper part is the index.
// Source: Wilhelms and Van Gelder 1992; Lee and Ihm §2.1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grid/coords.h"
#include "grid/value_range.h"
#include "grid/voxel_type.h"

namespace kiln {

/// Edge of a cell. unit: voxels.
inline constexpr std::int64_t kCellSize = 8;

class MinMaxOctree {
 public:
  MinMaxOctree() = default;
  /// shape: `cells` holds edge³ ranges, x fastest; cells outside the volume are empty. requires: edge is a power of
  /// two.
  MinMaxOctree(std::vector<ValueRange> cells, int edge);

  /// Number of levels: level 0 holds the cells, level depth() - 1 the root.
  int depth() const { return static_cast<int>(levels_.size()); }
  /// Nodes along an axis of a level.
  int edge(int level) const { return edge_ >> level; }
  const ValueRange& at(int level, int x, int y, int z) const {
    const std::int64_t n = edge(level);
    return levels_[static_cast<std::size_t>(level)][static_cast<std::size_t>((z * n + y) * n + x)];
  }
  std::span<const ValueRange> cells() const { return levels_.front(); }
  std::size_t bytes() const;

 private:
  int edge_ = 0;
  std::vector<std::vector<ValueRange>> levels_;
};

/// Computes the ranges of a brick's cells from its voxels. shape: `voxels` covers `box` (x fastest), which contains
/// `core`; the result has edge³ cells from the core's first voxel on, x fastest.
std::vector<ValueRange> cellRanges(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& box,
                                   const VoxelBox& core, int edge);

/// Returns the range of the voxels of `region`. requires: region inside box.
ValueRange rangeOf(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& box, const VoxelBox& region);

}  // namespace kiln
