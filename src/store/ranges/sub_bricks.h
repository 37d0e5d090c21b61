// Ranges of the 8³ sub-bricks inside a brick, stored in the index as two bytes each.
// A renderer selects the visible part of a brick before reading the brick. A brick may straddle the depths at which its
// level is drawn, or the edge of the visible region, and have nothing visible on the side that counts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grid/coords.h"
#include "grid/value_range.h"
#include "grid/voxel_type.h"

namespace kiln {

/// Largest number of sub-bricks of a brick along an axis.
inline constexpr int kMostSubBricks = 8;
/// Number of sub-bricks along an axis in stores of format 2.
inline constexpr int kEarlierSubBricks = 4;
/// Voxels beyond a sub-brick that cubic interpolation inside reads.
inline constexpr std::int64_t kSubBrickReach = 2;

/// Number of sub-bricks of a brick along an axis; a sub-brick consists of whole cells.
int subBricksOf(std::int64_t brick_size);
/// The voxels of sub-brick `at` in a brick with `along` sub-bricks per axis; empty if the brick ends before.
VoxelBox subBrickOf(const VoxelBox& core, std::int64_t brick_size, int along, const VoxelCoord& at);
/// The sub-bricks that meet `part`, as a box of `at`. requires: `part` meets the core.
VoxelBox subBricksIn(const VoxelBox& part, const VoxelBox& core, std::int64_t brick_size, int along);

/// Returns the range of each sub-brick. A range covers the voxels of the sub-brick, voxels within kSubBrickReach and,
/// at a face of the brick, the apron: everything that is interpolated or classified in the sub-brick and in the apron
/// beside it.
/// shape: as boxRanges, along³ ranges; empty for a sub-brick without voxels.
std::vector<ValueRange> subBrickRanges(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& box,
                                       const VoxelBox& core, std::int64_t brick_size, int along);

/// The ranges of sub-bricks, with ends rounded outward to 255ths of the brick's support.
class SubRanges {
 public:
  /// requires: along³ ranges inside `support`.
  SubRanges(int along, std::span<const ValueRange> ranges, const ValueRange& support);
  /// Restores ranges from the result of `bytes`. requires: bytesOf(along) bytes.
  SubRanges(int along, std::span<const std::byte> bytes);
  static std::size_t bytesOf(int along) { return 2 * countOf(along); }

  /// Number of sub-bricks along an axis, and in total.
  int along() const { return along_; }
  std::size_t count() const { return countOf(along_); }
  /// The bytes as in FORMAT.md: all minima, then all maxima; an empty range has its minimum above its maximum.
  std::span<const std::byte> bytes() const { return bytes_; }
  /// Returns a range that contains the original i-th range, or is empty if the original is. requires: the original
  /// `support`.
  ValueRange at(std::size_t i, const ValueRange& support) const;

  /// Makes the i-th range empty.
  void clear(std::size_t i);

  /// True if test(i, at) holds for any sub-brick `at`, the i-th of all, of a box of sub-bricks; stops at the first.
  template <class Test>
  bool any(const VoxelBox& box, Test&& test) const {
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
        for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
          if (test(static_cast<std::size_t>((z * along_ + y) * along_ + x), VoxelCoord{x, y, z})) return true;
        }
      }
    }
    return false;
  }
  /// As above, of all sub-bricks.
  template <class Test>
  bool any(Test&& test) const {
    return any(boxOf({along_, along_, along_}), test);
  }

  bool operator==(const SubRanges&) const = default;

 private:
  static std::size_t countOf(int along) {
    const auto n = static_cast<std::size_t>(along);
    return n * n * n;
  }
  int along_;
  std::vector<std::byte> bytes_;
};

}  // namespace kiln
