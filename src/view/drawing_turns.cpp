#include "view/drawing_turns.h"

#include <chrono>

namespace kiln {

DrawingTurns::Turn::Turn(DrawingTurns& turns, bool of_frame, const std::function<bool()>& gives_up) : turns_(turns) {
  constexpr auto kAskEvery = std::chrono::milliseconds(20);
  if (of_frame) ++turns_.frames_waiting_;
  {
    std::unique_lock lock(turns_.mutex_);
    const auto free = [&] { return !turns_.busy_ && (of_frame || turns_.frames_waiting_ == 0); };
    while (!free() && !gives_up()) turns_.changed_.wait_for(lock, kAskEvery);
    if (free() && !gives_up()) given_ = turns_.busy_ = true;
  }
  if (of_frame) --turns_.frames_waiting_;
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
