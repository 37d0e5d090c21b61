// The order of drawing: a single thread at a time, frames before other work, and the newest frame alone.
// Method. A new frame ends the frame before, and interrupts other work. Interrupted work waits and begins again.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>

namespace kiln {

class DrawingTurns {
 public:
  /// Returns the number of a new frame. The new frame supersedes all earlier frames. thread: any.
  std::uint64_t arrive() { return ++newest_; }
  bool superseded(std::uint64_t frame) const { return newest_ != frame; }
  /// True while a frame waits: other work should end soon. thread: any.
  bool framesWait() const { return frames_waiting_ > 0; }
  /// Wakes all waiting threads for a test whether to give up.
  void wake() { changed_.notify_all(); }

  /// The right to draw, until destruction.
  class Turn {
   public:
    /// Waits for the turn. Gives up, `given()` false, once `gives_up()` is true; asked now and then.
    Turn(DrawingTurns& turns, bool of_frame, const std::function<bool()>& gives_up);
    ~Turn();
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    bool given() const { return given_; }

   private:
    DrawingTurns& turns_;
    bool given_ = false;
  };

 private:
  std::atomic<std::uint64_t> newest_ = 0;
  std::atomic<int> frames_waiting_ = 0;
  std::mutex mutex_;  // guards `busy_`
  std::condition_variable changed_;
  bool busy_ = false;
};

}  // namespace kiln
