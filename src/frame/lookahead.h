// What a frame will need next: the bricks behind the one being drawn, in the order in which their turn comes, without
// those that are hidden already. The cache reads them while this one is drawn.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "frame/brick_walk.h"

namespace kiln {

class Lookahead {
 public:
  using Hidden = std::function<bool(const BrickInView&)>;
  /// `hidden` says of a brick that it touches nothing any more.
  Lookahead(std::vector<BrickInView> in_view, Hidden hidden)
      : in_view_(std::move(in_view)), is_hidden_(std::move(hidden)), known_hidden_(in_view_.size()) {}

  /// The turn of `drawn` has come: up to `count` bricks that come after it. requires: calls in the order of the frame.
  /// thread: not while tiles are drawn. cost: a test for each brick looked at, a bounded number of them.
  std::vector<BrickKey> after(const BrickKey& drawn, std::size_t count);

 private:
  std::vector<BrickInView> in_view_;
  const Hidden is_hidden_;
  std::vector<bool> known_hidden_;  // and so they stay
  std::size_t next_ = 0;
};

}  // namespace kiln
