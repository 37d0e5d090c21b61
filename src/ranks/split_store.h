// A store cut up for machines that hold a part of it on a disk of their own: what a rank reads that draws one box of
// the volume, at every level, beside the whole manifest and index.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "base/progress.h"
#include "store/store_reader.h"

namespace kiln {

struct StorePart {
  std::uint64_t bytes = 0;  // of the bricks that were linked or copied
  bool was_there = false;   // an earlier call had made it
};

/// Makes `directory` the part of the store that drawing `box` reads: its bricks are links to the store's where both are
/// on one file system, else copies. A part for this box that was made of this store before is kept; what a killed
/// process left unfinished is begun anew. throws: Error kExists where something else is there or another process makes
/// it, kNoSpace, kIo, kNotFound.
StorePart writeStorePart(const StoreReader& store, const VoxelBox& box, const std::filesystem::path& directory,
                         Progress& progress);

/// The box that `writeStorePart` made a directory for. throws: Error kNotFound, kFormat where it is no such part.
VoxelBox boxOfStorePart(const std::filesystem::path& directory);

/// Whether a part for `box` has a stored brick: whatever drawing it may ask for. requires: the store outlives it.
std::function<bool(const BrickKey&)> bricksOfStorePart(const StoreReader& store, const VoxelBox& box);

/// Of boxes that ranks hold: throws Error kUsage where they do not fill the volume, each voxel once.
void requireWhole(const std::vector<VoxelBox>& boxes, const Extent3& dims);

}  // namespace kiln
