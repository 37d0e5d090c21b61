// The order of drawing: a single thread at a time, frames before other work, and the newest frame of a page alone.
// Method. Frames are numbered as they arrive. A new frame ends the frame before of its page, goes before all frames
// that wait, and interrupts other work. Interrupted work waits and begins again, and goes before frames once urgent.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <limits>
#include <mutex>
#include <set>

namespace kiln {

class DrawingTurns {
 public:
  /// The frames of a page.
  class Page {
   public:
    bool superseded(std::uint64_t frame) const { return newest_ != frame; }

   private:
    friend class DrawingTurns;
    std::atomic<std::uint64_t> newest_ = 0;
  };
  /// Work that is no frame.
  static constexpr std::uint64_t kOther = 0;
  /// Work that goes before all frames, and interrupts those that give way.
  static constexpr std::uint64_t kUrgent = std::numeric_limits<std::uint64_t>::max();

  /// Returns the number of a new frame, which supersedes all earlier frames of the page. thread: any.
  std::uint64_t arrive(Page& page);
  /// True while a frame waits that is newer than `frame`, or any frame for kOther. thread: any.
  bool newerWaits(std::uint64_t frame) const { return newest_waiting_ > frame; }
  /// Wakes all waiting threads for a test whether to give up.
  void wake() { changed_.notify_all(); }

  /// The right to draw, until destruction.
  class Turn {
   public:
    /// Waits for the turn. Gives up, `given()` false, once `gives_up()` is true; asked now and then. Frames of equal
    /// numbers have no order.
    Turn(DrawingTurns& turns, std::uint64_t frame, const std::function<bool()>& gives_up);
    ~Turn();
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    bool given() const { return given_; }

   private:
    DrawingTurns& turns_;
    bool given_ = false;
  };

 private:
  std::atomic<std::uint64_t> newest_waiting_ = 0;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::uint64_t last_ = 0;
  std::multiset<std::uint64_t> waiting_;
  bool busy_ = false;
};

}  // namespace kiln
