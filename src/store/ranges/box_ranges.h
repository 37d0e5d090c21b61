// Computes the value ranges of many boxes of a brick at once. The boxes are all products of spans along the three axes.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "grid/coords.h"
#include "grid/value_range.h"
#include "grid/voxel_type.h"

namespace kiln {

/// Voxels [lo, hi) along an axis; empty if lo == hi. requires: lo <= hi.
struct VoxelSpan {
  std::int64_t lo = 0, hi = 0;
};

/// Returns the range of the voxels of each box, ignoring NaN. shape: `voxels` covers `box`, x fastest; the result has a
/// range for each spans[0][i] × spans[1][j] × spans[2][k], i fastest. requires: spans inside the box. cost: 1 ms for
/// the cells of 128³ voxels.
std::vector<ValueRange> boxRanges(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& box,
                                  const std::array<std::vector<VoxelSpan>, 3>& spans);

/// Upper bound of the working memory for `n` spans of at most `longest` voxels along each axis. unit: bytes.
inline std::size_t boxRangesScratch(std::int64_t width, std::int64_t n, std::int64_t longest, VoxelType type) {
  return static_cast<std::size_t>(2 * width * n * (longest + 1)) * sizeOf(type);
}

}  // namespace kiln
