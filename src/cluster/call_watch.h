// Detects a call that does not return.
// Problem. MPI starts and ends all ranks together, within calls: a stopped rank would keep all further ranks there for
// ever, and no message can tell of the rank.
// Method. A thread counts the time since its start. Time in which the process itself was stopped does not count.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <stop_token>
#include <thread>

namespace kiln {

/// A limit on a call: `found` is called by an internal thread, and ends the process.
struct CallLimit {
  double seconds = 0;  // 0: no limit
  std::function<void()> found;
};

/// Calls `found` unless destroyed within the limit.
class CallWatch {
 public:
  /// Without a limit, or a thread of the system, nothing is watched.
  explicit CallWatch(CallLimit limit);

 private:
  void wait(const std::stop_token& stop) const;

  const CallLimit limit_;
  std::optional<std::jthread> thread_;
};

}  // namespace kiln
