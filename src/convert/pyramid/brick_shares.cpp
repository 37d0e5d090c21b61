#include "convert/pyramid/brick_shares.h"

#include <algorithm>
#include <utility>

#include "store/manifest/manifest.h"

namespace kiln {
namespace {

// Small bricks are made faster than the counter can be asked. So a rank takes the voxels of one usual brick at once,
// but few enough bricks that a share can still be divided among helpers.
std::uint32_t bricksAtOnce(std::uint32_t share, std::int64_t brick_size) {
  const std::int64_t along = std::max<std::int64_t>(kDefaultBrickSize / brick_size, 1);
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(share / 32, 1, along * along * along));
}

}  // namespace

BrickShares::BrickShares(Ranks& ranks, std::vector<std::int64_t> bricks, std::int64_t brick_size, bool in_order)
    : bricks_(std::move(bricks)),
      bounds_(WorkRanges::evenBounds(bricks_.size(), in_order ? 1 : static_cast<std::size_t>(ranks.count()))),
      most_at_once_(in_order ? 1 : bricksAtOnce(bounds_[1], brick_size)),
      taken_(ranks.makeCounters(bounds_.size() - 1)),
      work_(*taken_, 0, bounds_, in_order ? 0 : static_cast<std::size_t>(ranks.rank())) {}

std::optional<std::int64_t> BrickShares::next() {
  const std::scoped_lock lock(mutex_);
  if (units_.begin == units_.end) {
    const auto units = work_.take(most_at_once_);
    if (!units) return std::nullopt;
    units_ = *units;
  }
  return bricks_[units_.begin++];
}

}  // namespace kiln
