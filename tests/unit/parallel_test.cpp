// What parallelFor promises to bodies that wait for one another.
#include "base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>

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

}  // namespace
}  // namespace kiln::test
