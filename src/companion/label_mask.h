// A mask: shows the voxels of a volume at which another volume has one of some labels.
// Problem. The mask may have another resolution and orientation, and may be larger than memory.
// Method. A voxel is shown if the label nearest to its position is listed. Bricks of the mask are packed to a bit per
// voxel when they are read, and some stay in memory. A box is hidden, without any reading, if the ranges in the mask's
// index have no listed label.
// Invariant. Positions outside the mask show nothing. A voxel's bit depends on its position and its level alone.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "companion/companion.h"
#include "companion/companion_place.h"
#include "companion/kept_bricks.h"
#include "store/codec/shown_voxels.h"

namespace kiln {

class LabelMask final : public Companion {
 public:
  /// requires: both volumes are placed in one world. throws: Error kUsage if `mask` holds no labels.
  LabelMask(std::unique_ptr<BrickedVolume> mask, std::vector<std::int64_t> labels, const Manifest& drawn);

  bool hides(int level, const VoxelBox& box) const override;
  bool addTo(BrickBlock& block) const override;
  std::uint64_t addedBytes(const VoxelBox& extent) const override { return ShownVoxels::bytesFor(extent); }
  std::uint64_t workBytes(int level, const VoxelBox& extent) const override;
  std::uint64_t heldBytes() const override;

 private:
  /// A brick of the mask: the voxels with a listed label, apron included.
  struct Packed {
    VoxelBox extent;  // the voxels of the mask
    ShownVoxels listed;
  };
  class Filling;
  static constexpr std::size_t kKept = 16;

  bool holdsListed(const ValueRange& range) const;
  /// Returns whether some part of a brick that meets `near` may hold a listed label, by the index.
  bool holdsListed(const BrickKey& key, const VoxelBox& near) const;
  bool isListed(double label) const;
  VoxelBox coreOf(const BrickKey& key) const;
  std::uint64_t packedBytes() const;
  Packed packedBrick(const BrickKey& key) const;

  const std::unique_ptr<BrickedVolume> mask_;
  const std::uint64_t most_read_;  // the largest BrickedVolume::readBytes of the mask. unit: bytes
  std::vector<double> labels_;     // sorted
  const CompanionPlace place_;
  mutable KeptBricks<Packed> kept_;
};

}  // namespace kiln
