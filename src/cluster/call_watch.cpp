#include "cluster/call_watch.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <utility>

namespace kiln {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr Seconds kStep{0.02};
// Longest counted gap between two steps. A longer gap means that the process was stopped.
constexpr Seconds kLongestStep{1};

}  // namespace

CallWatch::CallWatch(CallLimit limit) : limit_(std::move(limit)) {
  if (limit_.seconds <= 0) return;
  try {
    thread_.emplace([this](const std::stop_token& stop) { wait(stop); });
  } catch (const std::system_error&) {
    // The system allows no more threads (ulimit -u, -v).
  }
}

void CallWatch::wait(const std::stop_token& stop) const {
  using Clock = std::chrono::steady_clock;
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  Seconds waited{0};
  for (Clock::time_point last = Clock::now(); waited.count() < limit_.seconds;) {
    if (stopped.wait_for(lock, stop, kStep, [&] { return stop.stop_requested(); })) return;
    const Clock::time_point now = Clock::now();
    waited += std::min<Seconds>(now - std::exchange(last, now), kLongestStep);
  }
  limit_.found();
}

}  // namespace kiln
