// What parallelFor promises to bodies that wait for one another, and that a limit of threads limits.
#include "base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <set>
#include <thread>

namespace kiln::test {
namespace {

// Known because a body counts itself in on its thread: one that was begun inside of another would count two.
TEST(ParallelFor, BeginsNoBodyInsideOfAnother) {
  const ThreadLimit threads(4);
  std::atomic<int> nested = 0, inner = 0;
  parallelFor(200, [&](std::size_t) {
    thread_local int depth = 0;
    nested += ++depth > 1;
    parallelFor(50, [&](std::size_t) { ++inner; });
    --depth;
  });
  EXPECT_EQ(nested, 0);
  EXPECT_EQ(inner, 200 * 50);
}

// Known because one thread runs all the bodies where one is allowed, and no limit outlives its object.
TEST(ThreadLimit, HoldsWhileItLives) {
  const unsigned all = ThreadLimit::active();
  {
    const ThreadLimit threads(1);
    EXPECT_EQ(ThreadLimit::active(), 1u);
    std::mutex mutex;
    std::set<std::thread::id> seen;
    parallelFor(1000, [&](std::size_t) {
      const std::scoped_lock lock(mutex);
      seen.insert(std::this_thread::get_id());
    });
    EXPECT_EQ(seen, std::set<std::thread::id>{std::this_thread::get_id()});
  }
  EXPECT_EQ(ThreadLimit::active(), all);
  const ThreadLimit none(0);
  EXPECT_EQ(ThreadLimit::active(), all);
}

}  // namespace
}  // namespace kiln::test
