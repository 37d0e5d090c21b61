#include "convert/brick_shares.h"

#include <algorithm>
#include <utility>

#include "store/manifest.h"

namespace kiln {
namespace {

// Small bricks are made faster than one is asked for: as many at once as have the voxels of a usual one, but few enough
// that a share is still divided where others come to help.
std::uint64_t bricksAtOnce(std::uint64_t share, std::int64_t brick_size) {
  const std::int64_t along = std::max<std::int64_t>(kDefaultBrickSize / brick_size, 1);
  return std::clamp<std::uint64_t>(share / 32, 1, static_cast<std::uint64_t>(along * along * along));
}

}  // namespace

BrickShares::BrickShares(Ranks& ranks, std::vector<std::int64_t> bricks, std::int64_t brick_size, bool in_order)
    : ranks_(ranks),
      bricks_(std::move(bricks)),
      shares_(in_order ? 1 : static_cast<std::size_t>(ranks.count())),
      most_at_once_(in_order ? 1 : bricksAtOnce(bricks_.size() / shares_, brick_size)),
      taken_(ranks.makeCounters(shares_)),
      left_(shares_),
      share_(static_cast<std::size_t>(ranks.rank()) % shares_) {}

std::optional<std::int64_t> BrickShares::next() {
  const std::scoped_lock lock(mutex_);
  while (at_ == end_) {
    if (left_ == 0) return std::nullopt;
    const std::uint64_t end = first(share_ + 1);
    at_ = std::min(first(share_) + taken_->add(share_, most_at_once_), end);
    end_ = std::min(at_ + most_at_once_, end);
    if (at_ < end_) break;
    --left_;
    share_ = (share_ + 1) % shares_;
  }
  return bricks_[at_++];
}

}  // namespace kiln
