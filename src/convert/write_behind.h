// Writes bricks on a separate thread while lanes make the next bricks: waiting for a disk would leave a core idle.
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

#include "convert/resume/journal.h"
#include "store/store_writer.h"

namespace kiln {

/// A brick to be written, and the counts for its journal record.
struct UnwrittenBrick {
  EncodedBrick brick;
  ValueCounts counts;
};

class WriteBehind {
 public:
  using Write = std::function<void(const UnwrittenBrick&)>;

  /// Writes bricks in sequence on a separate thread; at most `most` bricks wait or are being written. With 0, `add`
  /// writes.
  WriteBehind(std::size_t most, Write write);
  /// Writes the waiting bricks, unless writing has failed.
  ~WriteBehind();
  WriteBehind(const WriteBehind&) = delete;
  WriteBehind& operator=(const WriteBehind&) = delete;

  /// Waits while there is no room. Bricks are written in the order of their addition. thread: safe. throws: the
  /// exception of `write`, for this brick or an earlier brick.
  void add(UnwrittenBrick brick);
  /// Waits until all bricks are written. throws: as `add`.
  void finish();

 private:
  void writeAll();

  const std::size_t most_;
  const Write write_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::deque<UnwrittenBrick> waiting_;  // the first brick is being written
  std::exception_ptr failure_;
  bool closing_ = false;
  std::thread writer_;
};

}  // namespace kiln
