#include "view/drawing_turns.h"

#include <chrono>

namespace kiln {

std::uint64_t DrawingTurns::arrive(Page& page) {
  const std::lock_guard lock(mutex_);
  page.newest_ = ++last_;
  return last_;
}

DrawingTurns::Turn::Turn(DrawingTurns& turns, std::uint64_t frame, const std::function<bool()>& gives_up)
    : turns_(turns) {
  constexpr auto kAskEvery = std::chrono::milliseconds(20);
  {
    std::unique_lock lock(turns_.mutex_);
    const auto note = [&] { turns_.newest_waiting_ = turns_.waiting_.empty() ? 0 : *turns_.waiting_.rbegin(); };
    const auto free = [&] { return !turns_.busy_ && turns_.newest_waiting_ <= frame; };
    const auto place = turns_.waiting_.insert(frame);
    note();
    while (!free() && !gives_up()) turns_.changed_.wait_for(lock, kAskEvery);
    if (free() && !gives_up()) given_ = turns_.busy_ = true;
    turns_.waiting_.erase(place);
    note();
  }
  if (!given_) turns_.changed_.notify_all();
}

DrawingTurns::Turn::~Turn() {
  if (!given_) return;
  {
    const std::lock_guard lock(turns_.mutex_);
    turns_.busy_ = false;
  }
  turns_.changed_.notify_all();
}

}  // namespace kiln
