// A store cut up for machines that hold a part of it on a disk of their own: what a rank reads that draws one box of
// the volume, at every level, beside the whole manifest and index.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "base/progress.h"
#include "store/store_reader.h"

namespace kiln {

/// Makes `directory` the part of the store that drawing `box` reads: its bricks are links to the store's where both are
/// on one file system, else copies. Returns their bytes. throws: Error kExists where something is there, kNoSpace, kIo,
/// kNotFound.
std::uint64_t writeStorePart(const StoreReader& store, const VoxelBox& box, const std::filesystem::path& directory,
                             Progress& progress);

/// The box that `writeStorePart` made a directory for. throws: Error kNotFound, kFormat where it is no such part.
VoxelBox boxOfStorePart(const std::filesystem::path& directory);

/// Whether a part for `box` has a stored brick: whatever drawing it may ask for. requires: the store outlives it.
std::function<bool(const BrickKey&)> bricksOfStorePart(const StoreReader& store, const VoxelBox& box);

/// Of boxes that ranks hold: throws Error kUsage where they do not fill the volume, each voxel once.
void requireWhole(const std::vector<VoxelBox>& boxes, const Extent3& dims);

}  // namespace kiln
