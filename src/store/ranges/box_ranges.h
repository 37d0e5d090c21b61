// The ranges of many boxes of a brick's voxels at once: those that a few spans along each axis make.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "grid/coords.h"
#include "grid/value_range.h"
#include "grid/voxel_type.h"

namespace kiln {

/// Voxels [lo, hi) along an axis; none where lo == hi. requires: lo <= hi.
struct VoxelSpan {
  std::int64_t lo = 0, hi = 0;
};

/// The range of the voxels of each box, NaN aside. shape: `voxels` covers `box`, x fastest; the result has a range for
/// each spans[0][i] × spans[1][j] × spans[2][k], i fastest. requires: spans inside of the box. cost: for the cells of
/// 128³ voxels 1 ms.
std::vector<ValueRange> boxRanges(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& box,
                                  const std::array<std::vector<VoxelSpan>, 3>& spans);

/// The most that this holds beside its result, of `n` spans of at most `longest` voxels along each axis. unit: bytes.
inline std::size_t boxRangesScratch(std::int64_t width, std::int64_t n, std::int64_t longest, VoxelType type) {
  return static_cast<std::size_t>(2 * width * n * (longest + 1)) * sizeOf(type);
}

}  // namespace kiln
