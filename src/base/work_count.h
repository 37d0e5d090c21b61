// Counts finished reads and writes of this process, and its waits for other processes, so a watchdog can distinguish
// progress from a disk that does not answer.
#pragma once

#include <atomic>
#include <cstdint>

namespace kiln {

/// Number of finished calls that read or wrote a file, and of rounds of waits for another process. thread: safe.
inline std::atomic<std::uint64_t>& workCount() {
  static std::atomic<std::uint64_t> count{0};
  return count;
}

inline void countWork() { workCount().fetch_add(1, std::memory_order_relaxed); }

}  // namespace kiln
