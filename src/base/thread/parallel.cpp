#include "base/thread/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace kiln {
namespace {

// The thread sanitizer does not see inside TBB. These functions declare what TBB guarantees: work before the loop is
// visible in bodies, and work of bodies is visible after the loop.
void publish([[maybe_unused]] void* to) {
#if defined(__SANITIZE_THREAD__)
  __tsan_release(to);
#endif
}
void observe([[maybe_unused]] void* from) {
#if defined(__SANITIZE_THREAD__)
  __tsan_acquire(from);
#endif
}

// Stores the first exception of a loop. TBB must not see the exception: it would cancel nested loops of other bodies,
// and OpenVDB frees its trees in such loops, so a cancelled loop leaks them.
class FirstFailure {
 public:
  bool happened() const { return happened_.load(std::memory_order_relaxed); }
  template <class F>
  void keepOf(F&& f) {
    try {
      f();
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
      happened_.store(true, std::memory_order_relaxed);
    }
  }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::mutex mutex_;
  std::exception_ptr failure_;
  std::atomic<bool> happened_ = false;
};

}  // namespace

void parallelFor(std::size_t count, const std::function<void(std::size_t)>& body) {
  if (count == 1) {
    body(0);
    return;
  }
  char begin = 0;
  char end = 0;
  FirstFailure failure;
  publish(&begin);
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, count, 1),
      [&](const tbb::blocked_range<std::size_t>& range) {
        observe(&begin);
        for (std::size_t i = range.begin(); i != range.end() && !failure.happened(); ++i) {
          // Isolated: otherwise a thread that waits for a loop inside its body would begin another body of this loop.
          failure.keepOf([&] { tbb::this_task_arena::isolate([&] { body(i); }); });
        }
        publish(&end);
      },
      tbb::simple_partitioner());
  observe(&end);
  failure.rethrow();
}

void parallelInLanes(std::size_t lanes, std::size_t count,
                     const std::function<void(std::size_t lane, std::size_t i)>& body) {
  std::atomic<std::size_t> begun = 0;
  FirstFailure failure;
  parallelFor(std::min(count, lanes), [&](std::size_t lane) {
    for (std::size_t i = begun++; i < count && !failure.happened(); i = begun++) failure.keepOf([&] { body(lane, i); });
  });
  failure.rethrow();
}

void parallelForInOrder(std::size_t count, const std::function<void(std::size_t)>& body) {
  parallelInLanes(ThreadLimit::active(), count, [&](std::size_t, std::size_t i) { body(i); });
}

// Constructed in place: TBB identifies a control by its address, and a copy limits nothing.
struct ThreadLimit::Control {
  explicit Control(unsigned threads) : limit(tbb::global_control::max_allowed_parallelism, threads) {}
  tbb::global_control limit;
};

ThreadLimit::ThreadLimit(unsigned threads) {
  if (threads > 0) control_ = std::make_unique<Control>(threads);
}

ThreadLimit::~ThreadLimit() = default;

unsigned ThreadLimit::active() {
  return static_cast<unsigned>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

}  // namespace kiln
