// Which process makes which bricks. Those of level 0 lie in the order of the lattice, a share for each rank; a rank
// that is through with its own helps whoever has most left (cluster/work_ranges.h). A coarser brick is made by one rank
// that all know without asking, near its share.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "cluster/work_ranges.h"
#include "grid/coords.h"

namespace kiln {

/// The rank that makes a coarser brick, the `place`-th of `count` of its level.
inline int ownerOf(std::size_t place, std::int64_t count, int ranks) {
  return static_cast<int>(static_cast<std::int64_t>(place) * ranks / count);
}

class BrickShares {
 public:
  /// Collective. `bricks` are places in the lattice of level 0, rising, the same on all ranks. With `in_order` every
  /// rank takes the next of all of them: for a source that is only read forwards. requires: `ranks` outlives this.
  BrickShares(Ranks& ranks, std::vector<std::int64_t> bricks, std::int64_t brick_size, bool in_order);
  /// The next brick of this rank; nothing once all are taken. thread: safe. cost: now and then a message there and
  /// back.
  std::optional<std::int64_t> next();

 private:
  const std::vector<std::int64_t> bricks_;
  const std::vector<std::uint32_t> bounds_;  // of the shares
  const std::uint32_t most_at_once_;
  std::mutex mutex_;                       // guards what follows
  std::unique_ptr<SharedCounters> taken_;  // of each share
  WorkRanges work_;
  WorkRanges::Units units_ = {};  // that this rank has taken and not yet begun
};

}  // namespace kiln
