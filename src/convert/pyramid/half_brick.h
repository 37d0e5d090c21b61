// What one brick gives to the next coarser level: its voxels at half resolution, and what its ranges say.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "store/codec/brick_ranges.h"

namespace kiln {

struct HalfBrick {
  /// The coarse voxels that the brick's core makes. unit: index coordinates of the coarser level.
  VoxelBox box;
  /// shape: box, x fastest, in the volume's type.
  std::vector<std::byte> voxels;
  /// The coarse cells that hold them (coarse voxel / 8), and the ranges of the fine cells below; a cell that other
  /// bricks share holds this one's share.
  VoxelBox cell_box;
  std::vector<ValueRange> cells;
  ValueRange support;

  /// What a part of so many coarse voxels takes, with what the allocator loses between parts. requires: its first voxel
  /// begins a cell, or it is within one.
  static std::uint64_t bytesOf(const Extent3& voxels, std::uint64_t voxel_bytes);
  std::uint64_t bytes() const { return bytesOf(box.extent(), voxels.size() / static_cast<std::uint64_t>(box.count())); }
};

/// What a coarse voxel is of those below it: their mean, or the most frequent of them, of equally frequent ones the
/// smallest that is not 0.
enum class Coarse { kMean, kMostFrequent };

/// Halves a brick along the axes where `by` is 2. A coarse voxel is the mean of the voxels below it that exist (in the
/// volume, and no NaN), rounded to the nearest value of the type, halves upwards; NaN where none exists; or the most
/// frequent of them. shape: `voxels` covers `box`, x fastest, which contains the core. thread: safe.
HalfBrick coarsePartOf(const BrickDesc& fine, std::span<const std::byte> voxels, const VoxelBox& box,
                       const BrickRanges& ranges, const Extent3& by, Coarse coarse = Coarse::kMean);

/// The part of a brick that has one value.
HalfBrick constantPartOf(const BrickDesc& fine, double value, const Extent3& by);

/// What of a part lies in `box`; with all of its voxels it keeps its cells, else it has none: who needs those needs
/// all.
HalfBrick cropped(const HalfBrick& part, const VoxelBox& box);

/// As bytes, for a file or another process of the same machine type, and back. throws: Error kDamaged naming `place`.
std::vector<std::byte> bytesOf(const HalfBrick& part);
HalfBrick partFrom(std::span<const std::byte> bytes, const std::filesystem::path& place);

/// Copies the voxels that two boxes have in common. shape: each span covers its box, x fastest, `voxel_bytes` each.
void copyCommon(std::span<const std::byte> from, const VoxelBox& from_box, std::span<std::byte> to,
                const VoxelBox& to_box, std::size_t voxel_bytes);

/// The coarse voxels that a box of fine ones makes.
VoxelBox coarseBox(const VoxelBox& fine, const Extent3& by);

}  // namespace kiln
