// Loops over independent items on all cores. TBB lives behind this header.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace kiln {

/// Calls body(i) once for each i in [0, count), in any order and on any thread, and waits for all.
/// throws: the first exception a body threw; the items not yet begun are then dropped.
/// thread: what a body wrote is visible to the caller afterwards. A body may wait for what another one has begun: the
/// thread of a body begins no other before its end, whatever loops of their own a body and its libraries run.
void parallelFor(std::size_t count, const std::function<void(std::size_t)>& body);

/// The same, but items are begun one after the other as threads come free: with the longest first, threads end
/// together.
void parallelForInOrder(std::size_t count, const std::function<void(std::size_t)>& body);

/// While it lives, at most `threads` threads run the loops of one caller; 0 leaves the machine's number.
class ThreadLimit {
 public:
  explicit ThreadLimit(unsigned threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;
  /// The number of threads in force now.
  static unsigned active();

 private:
  struct Control;
  std::unique_ptr<Control> control_;
};

}  // namespace kiln
