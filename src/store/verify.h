// Whether a store is what it says it is: every file against its checksum, and every range of values that culling relies
// on against the voxels. Goes on after what it finds, so that a user learns everything that is to be restored.
#pragma once

#include <cstdint>
#include <functional>

#include "base/progress.h"
#include "store/store_reader.h"

namespace kiln {

struct VerifyReport {
  std::uint64_t files = 0;    // checked: the bricks', the index and the manifest
  std::uint64_t damaged = 0;  // of these
};

/// Reads all of a store, as many bricks at a time as threads and memory allow. `damaged` is called once for each file
/// that is missing, cannot be read, or contradicts what the store says of it: one error that names the file, what was
/// found and what was expected. At level 0 the ranges of octree and index are those of the voxels; at a coarser level
/// they cover more than its own voxels, and must contain these. Files that are not the store's are noted. A directory
/// that is a part of a store says by `holds` which bricks it should have.
/// thread: `damaged` is called from any thread, one call at a time. throws: Error kBudget where one brick does not fit,
/// kCancelled.
VerifyReport verify(const StoreReader& store, std::uint64_t memory_bytes,
                    const std::function<void(const Error&)>& damaged, Progress& progress,
                    const std::function<bool(const BrickKey&)>& holds = {});

}  // namespace kiln
