// Known because the watched scope lasts until the limit is found, or ends far below the limit.
#include "cluster/call_watch.h"

#include <gtest/gtest.h>

#include <future>

namespace kiln::test {
namespace {

TEST(CallWatchTest, FindsACallThatDoesNotReturn) {
  std::promise<void> found;
  const CallWatch watch({0.05, [&] { found.set_value(); }});
  found.get_future().wait();
}

TEST(CallWatchTest, FindsNothingInACallThatReturns_orWithoutALimit) {
  bool found = false;
  for (const double limit_s : {0.0, 3600.0}) const CallWatch watch({limit_s, [&] { found = true; }});
  EXPECT_FALSE(found);
}

}  // namespace
}  // namespace kiln::test
