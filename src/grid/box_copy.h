// Copies voxels between arrays that cover boxes of one volume.
#pragma once

#include <cstddef>
#include <span>

#include "grid/coords.h"

namespace kiln {

/// Returns the index of a voxel in an array that covers `box`, x fastest. requires: the voxel lies in the box.
inline std::size_t offsetIn(const VoxelBox& box, const VoxelCoord& v) {
  const Extent3 n = box.extent();
  return static_cast<std::size_t>(((v.z - box.lo.z) * n.y + v.y - box.lo.y) * n.x + v.x - box.lo.x);
}

/// Copies the voxels of `part`. shape: each span covers its box, x fastest, `voxel_bytes` each. requires: `part` lies
/// in both boxes.
void copyPart(const VoxelBox& part, std::span<const std::byte> from, const VoxelBox& from_box, std::span<std::byte> to,
              const VoxelBox& to_box, std::size_t voxel_bytes) noexcept;

/// Copies the voxels in the intersection of two boxes. shape: as copyPart.
void copyCommon(std::span<const std::byte> from, const VoxelBox& from_box, std::span<std::byte> to,
                const VoxelBox& to_box, std::size_t voxel_bytes) noexcept;

/// Fills the voxels of `part` with one voxel. shape: `to` covers `to_box`, x fastest. requires: `part` lies in the box.
void fillPart(const VoxelBox& part, std::span<const std::byte> voxel, std::span<std::byte> to,
              const VoxelBox& to_box) noexcept;

}  // namespace kiln
