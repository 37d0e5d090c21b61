// Cuts a store into parts for machines with disks of their own. A part holds the whole manifest and index, and at each
// level the bricks for drawing one box of the volume.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "base/progress.h"
#include "store/store_reader.h"

namespace kiln {

struct StorePart {
  std::uint64_t bytes = 0;  // size of the bricks that were linked or copied
  bool was_there = false;   // an earlier call made the part
};

/// Writes the part of the store for drawing `box` to `directory`. Bricks are hard links on one file system, otherwise
/// copies. A finished part of the same store and box is kept; an unfinished part is started anew. throws: Error kExists
/// if the folder holds other files or another process writes the part, kNoSpace, kIo, kNotFound.
StorePart writeStorePart(const StoreReader& store, const VoxelBox& box, const std::filesystem::path& directory,
                         Progress& progress);

/// Returns the box of a part. throws: Error kNotFound, kFormat for a folder that is no part.
VoxelBox boxOfStorePart(const std::filesystem::path& directory);

/// Returns the box of a part; nothing for a whole store. In a whole store, an unreadable file of that name is noted.
std::optional<VoxelBox> findStorePart(const std::filesystem::path& store, Progress& progress);

/// Returns a test for the stored bricks that drawing `box` may read. requires: the store outlives the test.
std::function<bool(const BrickKey&)> bricksOfStorePart(const StoreReader& store, const VoxelBox& box);

/// throws: Error kUsage unless the boxes of the ranks cover each voxel of the volume exactly once.
void requireWhole(const std::vector<VoxelBox>& boxes, const Extent3& dims);

}  // namespace kiln
