// Guarantees of parallelFor for bodies that wait for each other, and of thread limits.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/thread/parallel.h"

namespace kiln::test {
namespace {

// Known because a body counts itself on its thread: a nested body would raise the count to two.
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

// Known because a body that holds the lock sees the start of all bodies before it.
TEST(ParallelForInOrder, BeginsEachItemOnceAndInOrder) {
  const ThreadLimit threads(4);
  std::mutex mutex;
  std::vector<std::size_t> begun;
  constexpr std::size_t kItems = 500;
  parallelForInOrder(kItems, [&](std::size_t i) {
    const std::scoped_lock lock(mutex);
    begun.push_back(i);
  });
  ASSERT_EQ(begun.size(), kItems);
  // Each thread may hold an item on the way to the lock.
  for (std::size_t n = 0; n < kItems; ++n) EXPECT_LT(begun[n], n + 4) << n;
  std::sort(begun.begin(), begun.end());
  for (std::size_t n = 0; n < kItems; ++n) EXPECT_EQ(begun[n], n);
  parallelForInOrder(0, [](std::size_t) { FAIL() << "there is none"; });
}

TEST(ParallelForInOrder, BeginsNothingAfterAFailure) {
  const ThreadLimit threads(1);
  std::size_t begun = 0;
  const auto fail_at_three = [&](std::size_t i) {
    ++begun;
    if (i == 3) throw std::runtime_error("three");
  };
  EXPECT_THROW(parallelForInOrder(1000, fail_at_three), std::runtime_error);
  EXPECT_EQ(begun, 4u);
}

// Known because a limit of 1 runs all bodies on a single thread, and a limit ends with its object.
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
