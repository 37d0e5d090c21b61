// What the index knows of the inside of a brick: the ranges of its 4³ sub-bricks, each as two bytes. Decides which part
// of a brick is worth drawing before it is read: a brick may straddle the depths where its level is drawn, or the edge
// of what is visible, with nothing to show on the side that counts.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grid/coords.h"
#include "grid/value_range.h"
#include "grid/voxel_type.h"

namespace kiln {

/// Sub-bricks of a brick along an axis.
inline constexpr int kSubBricks = 4;
/// How many voxels beyond a sub-brick interpolation in it takes: a cubic's.
inline constexpr std::int64_t kSubBrickReach = 2;

/// The edge of a sub-brick: whole cells, so that small bricks have fewer. unit: voxels.
std::int64_t subBrickSize(std::int64_t brick_size);
/// The voxels of sub-brick (x, y, z) of a brick. Empty where the brick ends before it.
VoxelBox subBrickOf(const VoxelBox& core, std::int64_t brick_size, const VoxelCoord& at);

/// Whether test(i, at) is true of any sub-brick `at` of a brick, the i-th of its ranges; asks no further then.
template <class Test>
bool anySubBrick(Test&& test) {
  std::size_t i = 0;
  for (std::int64_t z = 0; z < kSubBricks; ++z) {
    for (std::int64_t y = 0; y < kSubBricks; ++y) {
      for (std::int64_t x = 0; x < kSubBricks; ++x, ++i) {
        if (test(i, VoxelCoord{x, y, z})) return true;
      }
    }
  }
  return false;
}

/// The range of each sub-brick's voxels, of those within kSubBrickReach, and, where it ends with the brick, of the
/// apron: of all that is interpolated or classified in it, and in the apron beside it. shape: as boxRanges, kSubBricks³
/// of them; empty ranges where there is no voxel.
std::vector<ValueRange> subBrickRanges(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& box,
                                       const VoxelBox& core, std::int64_t brick_size);

/// Those ranges, ends rounded outward to 255ths of the brick's support.
class SubRanges {
 public:
  static constexpr std::size_t kCount = kSubBricks * kSubBricks * kSubBricks;

  SubRanges() = default;
  /// requires: kCount ranges inside of `support`.
  SubRanges(std::span<const ValueRange> ranges, const ValueRange& support);

  /// What contains the i-th range that was given, of the same support. Empty where that was.
  ValueRange at(std::size_t i, const ValueRange& support) const;

  bool operator==(const SubRanges&) const = default;

 private:
  // The bytes of FORMAT.md: least of all, then greatest; the least above the greatest where there is nothing.
  std::array<std::uint8_t, kCount> lo_{}, hi_{};
};
static_assert(sizeof(SubRanges) == 2 * SubRanges::kCount);

}  // namespace kiln
