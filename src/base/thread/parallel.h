// Loops over independent items on all cores. Only parallel.cpp includes TBB.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace kiln {

/// Calls body(i) once for each i in [0, count), in any order and on any thread, and waits for all calls.
/// throws: the first exception of a body; items not yet begun are then dropped.
/// thread: writes of a body are visible to the caller afterwards. A body may wait for work that another body has begun:
/// a thread begins no second body before the first returns, even if the first runs loops of its own.
void parallelFor(std::size_t count, const std::function<void(std::size_t)>& body);

/// As parallelFor, but items begin in order as threads become free. With the longest items first, all threads end
/// together.
void parallelForInOrder(std::size_t count, const std::function<void(std::size_t)>& body);

/// Calls body(lane, i) once for each i in [0, count). The items of a lane, of `lanes` lanes, follow each other, so a
/// lane may own data. Items begin in order. throws: the first exception of a body.
void parallelInLanes(std::size_t lanes, std::size_t count,
                     const std::function<void(std::size_t lane, std::size_t i)>& body);

/// Limits all loops of the process to `threads` threads during its lifetime; 0 keeps the limit in force.
class ThreadLimit {
 public:
  explicit ThreadLimit(unsigned threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;
  /// The number of threads now in force.
  static unsigned active();

 private:
  struct Control;
  std::unique_ptr<Control> control_;
};

}  // namespace kiln
