// A volume with companions: its bricks carry the companions' values, and bricks that a mask hides are not read.
// Method. The index is the volume's own, without bricks and sub-bricks that a companion hides by its index. When a
// brick is read, the companions come first: a brick without shown voxels is not read.
// Invariant. A block's companion values depend on the positions of its voxels alone, so that pictures are equal for all
// bricks, budgets, threads and ranks.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "companion/companion.h"

namespace kiln {

struct BrickEntry;

class AccompaniedVolume final : public BrickedVolume {
 public:
  /// cost: a look at the index of each companion for every brick, and for sub-bricks at the border of a mask.
  AccompaniedVolume(std::unique_ptr<BrickedVolume> volume, std::vector<std::unique_ptr<Companion>> companions);

  BrickBlock read(const BrickKey& key) const override;
  /// A brick of one value has companions that differ.
  std::optional<double> constantOf(const BrickKey& /*key*/) const override { return std::nullopt; }
  std::size_t readBytes(const BrickKey& key) const override;
  std::size_t blockBytes(const BrickKey& key) const override;
  std::uint64_t heldBytes() const override;
  std::unique_ptr<BrickedVolume> share() const override;

 private:
  bool hides(int level, const VoxelBox& box) const;
  /// Returns the entry of a brick without what the companions hide.
  BrickEntry shownEntry(const BrickKey& key) const;

  std::shared_ptr<const BrickedVolume> volume_;
  std::shared_ptr<const std::vector<std::unique_ptr<Companion>>> companions_;
};

}  // namespace kiln
