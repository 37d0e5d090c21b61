// Boxes of voxels out of the bricks of a volume.
#pragma once

#include <cstddef>
#include <span>

#include "base/progress.h"
#include "store/bricked_volume.h"

namespace kiln {

/// The bricks of a level that meet a box, x fastest.
class BricksOfBox {
 public:
  /// requires: the box lies in the level.
  BricksOfBox(const BrickedVolume& store, int level, const VoxelBox& box);

  struct Part {
    BrickKey key;
    VoxelBox box;  // the voxels of the brick's core in the box
  };
  std::size_t count() const { return static_cast<std::size_t>(bricks_.count()); }
  /// requires: i < count().
  Part at(std::size_t i) const;

 private:
  const BrickedVolume& store_;
  int level_;
  VoxelBox box_, bricks_;
};

/// Fills `out` with the voxels of a box of a level. Bricks are decoded on all threads, a brick a thread; bricks
/// of a single value are not decoded. shape: x fastest, densely packed, in the volume's type. requires: the box lies in
/// the level. throws: as BrickedVolume::read; Error kCancelled.
void readBox(const BrickedVolume& store, int level, const VoxelBox& box, const Progress& progress,
             std::span<std::byte> out);

}  // namespace kiln
