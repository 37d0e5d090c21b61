// Writes bricks while the next ones are made: a lane that waits for a disk leaves its core idle.
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

/// A brick to be written, and what its journal says of it.
struct UnwrittenBrick {
  EncodedBrick brick;
  ValueCounts counts;
};

class WriteBehind {
 public:
  using Write = std::function<void(const UnwrittenBrick&)>;

  /// At most `most` bricks wait or are being written, one after the other, on a thread of this object's own; with 0,
  /// `add` writes.
  WriteBehind(std::size_t most, Write write);
  /// Writes what still waits, unless writing has failed.
  ~WriteBehind();
  WriteBehind(const WriteBehind&) = delete;
  WriteBehind& operator=(const WriteBehind&) = delete;

  /// Waits while there is no room. Bricks are written in the order in which they are added. thread: safe. throws: what
  /// `write` threw, for this brick or one before it.
  void add(UnwrittenBrick brick);
  /// Waits until all is written. throws: as `add`.
  void finish();

 private:
  void writeAll();

  const std::size_t most_;
  const Write write_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::deque<UnwrittenBrick> waiting_;  // the first is being written
  std::exception_ptr failure_;
  bool closing_ = false;
  std::thread writer_;
};

}  // namespace kiln
