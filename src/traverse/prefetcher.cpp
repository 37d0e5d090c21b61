#include "traverse/prefetcher.h"

#include <algorithm>

namespace kiln {

// A single wrong guess is free, so that there is always a guess to learn from.
bool Prefetcher::guesses() const {
  constexpr std::size_t kPartThatMayBeWrong = 32;
  return wrong_ <= 1 + drawn_ / kPartThatMayBeWrong;
}

// Counts the brick as a wrong guess if it is a guess.
void Prefetcher::notDrawn(const BrickKey& brick) { wrong_ += guessed_.erase(brick); }

std::size_t Prefetcher::turnOf(const BrickKey& brick) {
  for (; next_ < in_view_.size() && in_view_[next_].key != brick; ++next_) notDrawn(in_view_[next_].key);
  if (next_ < in_view_.size()) undrawn_.push_back(in_view_[next_++]);
  return next_;
}

std::vector<NextBrick> Prefetcher::next(std::size_t count) {
  // Most bricks examined per call. Hidden bricks stay hidden, so a longer search only does work of the next call.
  constexpr std::size_t kLooks = 64;
  std::vector<PixelRect> covered;
  for (const BrickInView& brick : undrawn_) covered.push_back(brick.rect);
  std::vector<NextBrick> out;
  std::size_t read = 0;
  for (std::size_t i = next_; i < in_view_.size() && i < next_ + kLooks && read < count; ++i) {
    if (known_hidden_[i]) continue;
    const BrickInView& brick = in_view_[i];
    const bool guess = is_hidden_(brick, covered);
    if (guess && is_hidden_(brick, {})) {
      known_hidden_[i] = true;
      notDrawn(brick.key);
      continue;
    }
    covered.push_back(brick.rect);
    const bool reads = !guess || guesses();
    if (guess && reads) guessed_.insert(brick.key);
    out.push_back({{brick.key, store_}, reads});
    read += reads ? 1 : 0;
  }
  return out;
}

void Prefetcher::announce(BrickCache& cache) {
  // Bricks read ahead at a time: enough to keep every reader busy while one brick is drawn.
  constexpr std::size_t kAnnounced = 8;
  if (!cache.readsAhead()) return;
  if (!reads_) {
    reads_ = std::any_of(in_view_.begin(), in_view_.end(), [&](const BrickInView& brick) {
      return !cache.holds({brick.key, store_});
    });
    // A cancelled frame leaves its announcements, whose bricks would replace those of this frame.
    if (!*reads_) cache.announce({});
  }
  if (*reads_) cache.announce(next(kAnnounced));
}

void Prefetcher::drew(const BrickKey& key, bool changed) {
  std::erase_if(undrawn_, [&](const BrickInView& brick) { return brick.key == key; });
  const bool guessed = guessed_.erase(key) > 0;
  drawn_ += changed ? 1 : 0;
  wrong_ += guessed && !changed ? 1 : 0;
}

}  // namespace kiln
