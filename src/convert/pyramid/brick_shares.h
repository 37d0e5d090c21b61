// Distributes bricks over processes. Bricks of level 0 are in lattice order, with a share per rank; a rank that has
// finished helps the rank with most bricks left (cluster/work_ranges.h). Each coarser brick is built by a fixed rank,
// near the rank's share, which all ranks can compute.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "cluster/work_ranges.h"
#include "grid/coords.h"

namespace kiln {

/// Returns the builder of a coarser brick, at `place` among the `count` bricks of the level.
inline int ownerOf(std::size_t place, std::int64_t count, int ranks) {
  return static_cast<int>(static_cast<std::int64_t>(place) * ranks / count);
}

class BrickShares {
 public:
  /// Collective. `bricks` are places in the lattice of level 0, equal on all ranks: of several ranks in rising order.
  /// With `in_order` the ranks take bricks from one list, in order: for a source that can only be read forwards.
  /// requires: `ranks` outlives this.
  BrickShares(Ranks& ranks, std::vector<std::int64_t> bricks, std::int64_t brick_size, bool in_order);
  /// Returns the next brick of this rank; nothing once all are taken. thread: safe. cost: occasionally a message there
  /// and back.
  std::optional<std::int64_t> next();

 private:
  const std::vector<std::int64_t> bricks_;
  const std::vector<std::uint32_t> bounds_;  // boundaries of the shares
  const std::uint32_t most_at_once_;
  std::mutex mutex_;                       // guards the members below
  std::unique_ptr<SharedCounters> taken_;  // bricks taken from each share
  WorkRanges work_;
  WorkRanges::Units units_ = {};  // taken by this rank and not yet begun
};

}  // namespace kiln
