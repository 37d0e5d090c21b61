// A volume whose bricks are cut from a source when they are read, without a store.
// Method. The volume is read once: each brick gets its entry in the index, and leaves its half-resolution part in the
// next coarser level, which is an array in memory. Bricks of level 0 are read from the source again.
// Invariant. Manifest, index and bricks equal those of a conversion, except files and checksums.
#pragma once

#include <memory>
#include <vector>

#include "convert/open_array.h"
#include "convert/pyramid/half_brick.h"

namespace kiln {

/// A coarser level in memory.
struct CoarseLevel {
  CoarseLevel(const Extent3& dims, VoxelType type);

  VoxelBox box;       // the whole level
  UnsetBytes voxels;  // shape: box, x fastest
  VoxelBox cell_box;
  std::vector<ValueRange> cells;  // shape: cell_box, x fastest; values of this level and of finer levels

  /// Memory of a level. unit: bytes.
  static std::uint64_t bytesOf(const Extent3& dims, VoxelType type);
};

class SourceVolume final : public BrickedVolume {
 public:
  /// requires: a source that is read in any order. throws: as openArray, and the exceptions of the source.
  SourceVolume(std::unique_ptr<VolumeSource> source, const ArrayOptions& options, Progress& progress);

  BrickBlock read(const BrickKey& key) const override;
  std::size_t readBytes(const BrickKey& key) const override;
  std::uint64_t heldBytes() const override;
  std::unique_ptr<BrickedVolume> share() const override;

 private:
  std::shared_ptr<VolumeSource> source_;
  std::shared_ptr<const std::vector<CoarseLevel>> coarse_;  // levels from 1 on
};

}  // namespace kiln
