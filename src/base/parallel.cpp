#include "base/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace kiln {
namespace {

// TBB's scheduler is a library that the thread sanitizer does not see into. These two say what it guarantees: what
// came before the loop is visible in its bodies, and what the bodies did is visible after it.
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

}  // namespace

void parallelFor(std::size_t count, const std::function<void(std::size_t)>& body) {
  if (count == 1) {
    body(0);
    return;
  }
  char begin = 0;
  char end = 0;
  publish(&begin);
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, count, 1),
      [&](const tbb::blocked_range<std::size_t>& range) {
        observe(&begin);
        for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
        publish(&end);
      },
      tbb::simple_partitioner());
  observe(&end);
}

struct ThreadLimit::Control {
  tbb::global_control limit;
};

ThreadLimit::ThreadLimit(unsigned threads) {
  if (threads > 0) {
    control_ =
        std::make_unique<Control>(Control{tbb::global_control(tbb::global_control::max_allowed_parallelism, threads)});
  }
}

ThreadLimit::~ThreadLimit() = default;

unsigned ThreadLimit::active() {
  return static_cast<unsigned>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

}  // namespace kiln
