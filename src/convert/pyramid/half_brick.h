// The contribution of a brick to the next coarser level: voxels at half resolution, and value ranges.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "grid/volume_info.h"
#include "store/codec/brick_ranges.h"

namespace kiln {

struct HalfBrick {
  /// The coarse voxels made from the brick's core. unit: index coordinates of the coarser level.
  VoxelBox box;
  /// shape: box, x fastest, in the volume's type.
  std::vector<std::byte> voxels;
  /// The coarse cells that contain the voxels (coarse voxel / 8), and the ranges of the fine cells below. A cell shared
  /// with neighbouring bricks has this brick's share only.
  VoxelBox cell_box;
  std::vector<ValueRange> cells;
  ValueRange support;

  /// Memory of a part of `voxels` coarse voxels, with the allocator's loss between parts. requires: the part's first
  /// voxel begins a cell, or the part lies within one cell.
  static std::uint64_t bytesOf(const Extent3& voxels, std::uint64_t voxel_bytes);
  std::uint64_t bytes() const { return bytesOf(box.extent(), voxels.size() / static_cast<std::uint64_t>(box.count())); }
};

/// Value of a coarse voxel: the mean of the voxels below, or their most frequent value (on a tie the smallest that is
/// not 0).
enum class Coarse { kMean, kMostFrequent };
inline Coarse coarseOf(VolumeClass volume_class) {
  return volume_class == VolumeClass::kLabels ? Coarse::kMostFrequent : Coarse::kMean;
}

/// Returns the cells that contain the voxels of a box.
inline VoxelBox cellsOf(const VoxelBox& box) { return coarseBox(box, kCellSize); }
/// Returns the cells of BrickRanges: a cube from the core's first cell on, also where the volume ends inside the brick.
VoxelBox cellCubeOf(const BrickDesc& brick);
/// Includes the ranges of the cells that two boxes of cells have in common. shape: each span covers its box, x fastest.
void includeCells(std::span<const ValueRange> from, const VoxelBox& from_box, std::span<ValueRange> to,
                  const VoxelBox& to_box);

/// Halves a brick along the axes where `by` is 2. The mean covers the voxels that exist (in the volume, not NaN),
/// rounded to the nearest value of the type, halves upwards; NaN if no voxel exists.
/// shape: `voxels` covers `box`, x fastest, which contains the core. thread: safe.
HalfBrick coarsePartOf(const BrickDesc& fine, std::span<const std::byte> voxels, const VoxelBox& box,
                       const BrickRanges& ranges, const Extent3& by, Coarse coarse = Coarse::kMean);

/// Returns the part of a constant brick.
HalfBrick constantPartOf(const BrickDesc& fine, double value, const Extent3& by);

/// Returns the portion of a part in `box`. A complete part keeps its cells. A portion has no cells: only the parent of
/// the complete part uses them.
HalfBrick cropped(const HalfBrick& part, const VoxelBox& box);

/// Converts to bytes and back, for a file or another process of equal machine type. throws: Error kDamaged naming
/// `place`.
std::vector<std::byte> bytesOf(const HalfBrick& part);
HalfBrick partFrom(std::span<const std::byte> bytes, const std::filesystem::path& place);

}  // namespace kiln
