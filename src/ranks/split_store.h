// Cuts a store into parts for machines with disks of their own. A part holds the whole manifest and index, and at each
// level the bricks that drawing one box of the volume reads.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "base/progress.h"
#include "store/store_reader.h"

namespace kiln {

struct StorePart {
  std::uint64_t bytes = 0;  // size of the bricks that were linked or copied
  bool was_there = false;   // an earlier call made the part
};

/// Writes the part of the store that drawing `box` reads to `directory`. Bricks are hard links where both folders are
/// on one file system, else copies. A finished part of the same store and box is kept; a part that a killed process
/// left unfinished is started anew. throws: Error kExists where the folder holds something else or another process
/// writes the part, kNoSpace, kIo, kNotFound.
StorePart writeStorePart(const StoreReader& store, const VoxelBox& box, const std::filesystem::path& directory,
                         Progress& progress);

/// Returns the box of a part. throws: Error kNotFound, kFormat where the folder is no part.
VoxelBox boxOfStorePart(const std::filesystem::path& directory);

/// Returns a test for the stored bricks that drawing `box` may read. requires: the store outlives the test.
std::function<bool(const BrickKey&)> bricksOfStorePart(const StoreReader& store, const VoxelBox& box);

/// throws: Error kUsage where the boxes of the ranks do not fill the volume, each voxel once.
void requireWhole(const std::vector<VoxelBox>& boxes, const Extent3& dims);

}  // namespace kiln
