// The interface of companions: volumes that lie at the same place as a drawn volume and are read at its voxels.
// A companion adds values to the decoded bricks of the drawn volume; engines find them in the block
// (store/codec/brick_block.h) and know no companion.
#pragma once

#include <cstdint>
#include <memory>

#include "store/bricked_volume.h"
#include "store/codec/brick_block.h"

namespace kiln {

class Companion {
 public:
  virtual ~Companion() = default;

  /// True if no voxel of the box, of a level of the drawn volume, is shown. Conservative: reads the companion's index
  /// alone. thread: safe.
  virtual bool hides(int level, const VoxelBox& box) const = 0;
  /// Adds the companion's values at the voxels of `block.extent`. Returns false if no voxel of the block is shown.
  /// requires: key and extent of the block are set. thread: safe. throws: as BrickedVolume::read of the companion.
  virtual bool addTo(BrickBlock& block) const = 0;

  /// Returns the largest memory that `addTo` adds to a block. unit: bytes.
  virtual std::uint64_t addedBytes(const VoxelBox& extent) const = 0;
  /// Returns the scratch memory of a call of `addTo`. unit: bytes.
  virtual std::uint64_t workBytes(int level, const VoxelBox& extent) const = 0;
  /// Returns the memory of the index and of bricks that stay in memory. unit: bytes.
  virtual std::uint64_t heldBytes() const = 0;
};

}  // namespace kiln
