// Opens an array in memory as a volume that is drawn without a store.
#pragma once

#include <cstdint>
#include <memory>

#include "base/progress.h"
#include "ingest/open_source.h"
#include "store/bricked_volume.h"

namespace kiln {

struct ArrayOptions {
  /// A power of two from 8 to 4096.
  std::int64_t brick_size = kDefaultBrickSize;
  /// Values are labels, not amounts, as in ConvertOptions. requires: whole numbers.
  bool labels = false;
  /// Upper bound for the coarser levels and the index. unit: bytes.
  std::uint64_t memory_bytes = UINT64_MAX;
};

/// Opens an array for runRenderJob. A picture equals, bit for bit, the picture of the array's conversion to a store.
/// Bricks of level 0 are copied from the array when they are drawn; coarser levels are made here, by all threads.
/// requires: the array's voxels outlive the volume and all its shares, and do not change.
/// throws: Error kUsage (options, no voxels), kFormat (dims, affine), kBudget before any level is made, kCancelled.
/// cost: reads the array once; memory of a seventh of the array.
std::unique_ptr<BrickedVolume> openArray(const VoxelArray& array, const ArrayOptions& options, Progress& progress);

}  // namespace kiln
