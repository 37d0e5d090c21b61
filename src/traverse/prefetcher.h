// Where a frame is among its bricks, and what it will need next: those behind the one being drawn, in the order in
// which their turn comes, without those that are hidden already. The cache reads them while this one is drawn. Those of
// which nothing would be seen if what comes before them were opaque are a guess: it is made as long as guesses prove
// right, and so in media that one sees through, and not behind a surface.
#pragma once

#include <functional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "cache/brick_cache.h"
#include "traverse/brick_walk.h"

namespace kiln {

class Prefetcher {
 public:
  using Hidden = std::function<bool(const BrickInView&, std::span<const PixelRect> covered)>;
  /// `hidden` says of a brick that it touches nothing any more, or nothing but what lies in one of `covered`.
  Prefetcher(std::vector<BrickInView> in_view, Hidden hidden)
      : in_view_(std::move(in_view)), is_hidden_(std::move(hidden)), known_hidden_(in_view_.size()) {}

  /// The turn of a brick has come: how many have had theirs, it and those that were passed over with them. requires:
  /// calls in the order of the frame.
  std::size_t turnOf(const BrickKey& brick);
  /// What comes after it, or first of all, up to `count` bricks that are to be read ahead. thread: not while tiles are
  /// drawn. cost: one or two tests for each brick looked at, a bounded number of them.
  std::vector<NextBrick> next(std::size_t count);
  /// A brick whose turn had come is drawn, and has changed a pixel, or has not.
  void drew(const BrickKey& key, bool changed);

 private:
  bool guesses() const;

  std::vector<BrickInView> in_view_;
  const Hidden is_hidden_;
  std::vector<bool> known_hidden_;  // and so they stay
  std::size_t next_ = 0;
  std::vector<BrickInView> undrawn_;   // whose turn has come
  std::set<BrickKey> guessed_;         // and not drawn yet
  std::size_t wrong_ = 0, drawn_ = 0;  // guesses for nothing; all that has changed a pixel
};

}  // namespace kiln
