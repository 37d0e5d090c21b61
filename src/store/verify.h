// Verifies a store: every file against its checksum, and every value range used for culling against the voxels.
// Continues after errors, so the user sees everything that must be restored.
#pragma once

#include <cstdint>
#include <functional>

#include "base/progress.h"
#include "store/store_reader.h"

namespace kiln {

struct VerifyReport {
  std::uint64_t files = 0;    // bricks, index and manifest
  std::uint64_t damaged = 0;  // number of damaged files
};

/// Reads the whole store, with as many bricks at a time as threads and memory allow. Calls `damaged` once per file that
/// is missing, unreadable, or contradicts the store: an error with the file, the found and the expected contents.
/// At level 0 the ranges of octree and index must equal those of the voxels; at a coarser level they also cover finer
/// levels and must contain those of the voxels. Foreign files in the store are noted. For a part of a store `holds`
/// selects the expected bricks.
/// thread: `damaged` is called from any thread, one call at a time. throws: Error kBudget if one brick does not fit,
/// kCancelled.
VerifyReport verify(const StoreReader& store, std::uint64_t memory_bytes,
                    const std::function<void(const Error&)>& damaged, Progress& progress,
                    const std::function<bool(const BrickKey&)>& holds = {});

}  // namespace kiln
