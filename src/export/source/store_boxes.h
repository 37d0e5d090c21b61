// Boxes of voxels out of the bricks of a store.
#pragma once

#include <cstddef>
#include <span>

#include "base/progress.h"
#include "store/store_reader.h"

namespace kiln {

/// Fills `out` with the voxels of a box of a level. Bricks are decoded on all threads, each thread holding one. shape:
/// x fastest, densely packed, in the store's type. requires: the box lies in the level. throws: as StoreReader::read;
/// Error kCancelled.
void readBox(const StoreReader& store, int level, const VoxelBox& box, const Progress& progress,
             std::span<std::byte> out);

/// Copies the voxels of `part` from a box to a box. shape: both x fastest, densely packed. requires: `part` lies in
/// both boxes.
void copyVoxels(const VoxelBox& part, std::size_t voxel_bytes, const VoxelBox& from_box, const std::byte* from,
                const VoxelBox& to_box, std::byte* to) noexcept;

}  // namespace kiln
