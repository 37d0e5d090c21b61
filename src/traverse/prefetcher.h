// Selects the bricks to read ahead: the next bricks in drawing order that are not hidden. The cache reads them while
// the current brick is drawn.
// Method. A brick that earlier undrawn bricks would hide if they were opaque is a guess. A guess is wrong if the brick
// becomes hidden or changes no pixel. Guesses are read only while wrong guesses are few beside the drawn bricks: in
// translucent media, but not behind a surface.
#pragma once

#include <functional>
#include <optional>
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
  /// `hidden` returns true if the brick is hidden, or touches only pixels in rectangles of `covered`. `store`: the
  /// place of the bricks' volume among the volumes of the cache.
  Prefetcher(std::vector<BrickInView> in_view, Hidden hidden, int store = 0)
      : store_(store), in_view_(std::move(in_view)), is_hidden_(std::move(hidden)), known_hidden_(in_view_.size()) {}

  /// Advances to `brick` and returns the number of bricks before and including it, drawn or skipped. requires: calls in
  /// drawing order.
  std::size_t turnOf(const BrickKey& brick);
  /// Returns the bricks after the current one, or the first bricks, of which up to `count` are to be read ahead.
  /// thread: not while tiles are drawn. cost: up to two tests per examined brick, and a bounded number of bricks.
  std::vector<NextBrick> next(std::size_t count);
  /// Announces the next bricks to a cache that reads ahead, unless all bricks were in memory at the first call. Bricks
  /// that leave memory later are read when their turn comes. thread: as `next`.
  void announce(BrickCache& cache);
  /// Records a drawn brick and whether a pixel changed.
  void drew(const BrickKey& key, bool changed);

 private:
  bool guesses() const;
  void notDrawn(const BrickKey& brick);

  const int store_;
  std::vector<BrickInView> in_view_;
  const Hidden is_hidden_;
  std::vector<bool> known_hidden_;  // a hidden brick stays hidden
  std::optional<bool> reads_;       // some brick was not in memory at the first announcement
  std::size_t next_ = 0;
  std::vector<BrickInView> undrawn_;   // reached, not yet drawn
  std::set<BrickKey> guessed_;         // guesses neither drawn nor hidden yet
  std::size_t wrong_ = 0, drawn_ = 0;  // guesses hidden or without a changed pixel; drawn bricks with one
};

}  // namespace kiln
