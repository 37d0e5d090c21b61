// Values of another volume, whose colours a volume is drawn in: a PET on a CT.
// Method. The values are interpolated linearly at the voxels of the drawn volume; labels are copied from the nearest
// voxel. Engines interpolate both between voxels, as they interpolate the drawn volume.
// Invariant. Positions outside the other volume have no value (NaN). A voxel's value depends on its position and its
// level alone.
#pragma once

#include <memory>

#include "companion/companion.h"
#include "companion/companion_place.h"
#include "companion/kept_bricks.h"

namespace kiln {

class ColorValues final : public Companion {
 public:
  /// requires: both volumes are placed in one world.
  ColorValues(std::unique_ptr<BrickedVolume> values, const Manifest& drawn);

  bool hides(int /*level*/, const VoxelBox& /*box*/) const override { return false; }
  bool addTo(BrickBlock& block) const override;
  std::uint64_t addedBytes(const VoxelBox& extent) const override {
    return static_cast<std::uint64_t>(extent.count()) * sizeof(float);
  }
  std::uint64_t workBytes(int level, const VoxelBox& extent) const override;
  std::uint64_t heldBytes() const override;

 private:
  class Filling;
  static constexpr std::size_t kKept = 4;
  /// Reach of samples beyond a brick's core. Voxels farther away have no value.
  static constexpr std::int64_t kReach = 2;

  const std::unique_ptr<BrickedVolume> values_;
  const std::uint64_t most_read_;  // the largest BrickedVolume::readBytes of the values. unit: bytes
  const CompanionPlace place_;
  const bool nearest_;        // labels
  const std::int64_t apron_;  // apron of the drawn volume
  mutable KeptBricks<BrickBlock> kept_;
};

}  // namespace kiln
