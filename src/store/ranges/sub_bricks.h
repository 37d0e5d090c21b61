// What the index knows of the inside of a brick: the ranges of its 8³ sub-bricks, each as two bytes. Decides which part
// of a brick is worth drawing before it is read: a brick may straddle the depths where its level is drawn, or the edge
// of what is visible, with nothing to show on the side that counts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grid/coords.h"
#include "grid/value_range.h"
#include "grid/voxel_type.h"

namespace kiln {

/// Sub-bricks of a brick along an axis, at the most.
inline constexpr int kMostSubBricks = 8;
/// How many there were in stores of format 2.
inline constexpr int kEarlierSubBricks = 4;
/// How many voxels beyond a sub-brick interpolation in it takes: a cubic's.
inline constexpr std::int64_t kSubBrickReach = 2;

/// Sub-bricks of a brick along an axis: they are whole cells.
int subBricksOf(std::int64_t brick_size);
/// The voxels of sub-brick `at` of a brick that has `along` of them along an axis. Empty where the brick ends before
/// it.
VoxelBox subBrickOf(const VoxelBox& core, std::int64_t brick_size, int along, const VoxelCoord& at);

/// The range of each sub-brick's voxels, of those within kSubBrickReach, and, where it ends with the brick, of the
/// apron: of all that is interpolated or classified in it, and in the apron beside it. shape: as boxRanges, along³ of
/// them; empty ranges where there is no voxel.
std::vector<ValueRange> subBrickRanges(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& box,
                                       const VoxelBox& core, std::int64_t brick_size, int along);

/// Those ranges, ends rounded outward to 255ths of the brick's support.
class SubRanges {
 public:
  /// requires: along³ ranges inside of `support`.
  SubRanges(int along, std::span<const ValueRange> ranges, const ValueRange& support);
  /// Of what `bytes` gave. requires: bytesOf(along) of them.
  SubRanges(int along, std::span<const std::byte> bytes);
  static std::size_t bytesOf(int along) { return 2 * countOf(along); }

  /// How many there are along an axis, and in all.
  int along() const { return along_; }
  std::size_t count() const { return countOf(along_); }
  /// As FORMAT.md has them: least of all, then greatest; the least above the greatest where there is nothing.
  std::span<const std::byte> bytes() const { return bytes_; }
  /// What contains the i-th range that was given, of the same support. Empty where that was.
  ValueRange at(std::size_t i, const ValueRange& support) const;

  /// Whether test(i, at) is true of any sub-brick `at`, the i-th; asks no further then.
  template <class Test>
  bool any(Test&& test) const {
    std::size_t i = 0;
    for (std::int64_t z = 0; z < along_; ++z) {
      for (std::int64_t y = 0; y < along_; ++y) {
        for (std::int64_t x = 0; x < along_; ++x, ++i) {
          if (test(i, VoxelCoord{x, y, z})) return true;
        }
      }
    }
    return false;
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
