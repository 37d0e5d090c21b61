// Work given to a WorkerThread runs on another thread, and its exception reaches the caller of wait().
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>

#include "base/thread/worker_thread.h"

namespace kiln::test {
namespace {

// Known because the work waits for its owner: on the owner's thread the test would never end.
TEST(WorkerThread, DoesOneThingWhileItsOwnerGoesOn) {
  WorkerThread beside("works");
  std::atomic<bool> owner_went_on = false;
  std::thread::id where;
  for (int i = 0; i < 3; ++i) {
    owner_went_on = false;
    beside.begin([&] {
      owner_went_on.wait(false);
      where = std::this_thread::get_id();
    });
    owner_went_on = true;
    owner_went_on.notify_all();
    beside.wait();
    EXPECT_NE(where, std::this_thread::get_id());
    beside.wait();  // no work was started
  }
}

TEST(WorkerThread, WhatIsThrownIsHeardOnce) {
  WorkerThread beside("works");
  beside.begin([] { throw std::runtime_error("full disk"); });
  EXPECT_THROW(beside.wait(), std::runtime_error);
  EXPECT_NO_THROW(beside.wait());
  int done = 0;
  beside.begin([&] { ++done; });
  beside.wait();
  EXPECT_EQ(done, 1);
}

TEST(WorkerThread, WaitsBeforeItGoesAway) {
  int done = 0;
  {
    WorkerThread beside("works");
    beside.begin([&] { ++done; });
  }
  EXPECT_EQ(done, 1);
}

}  // namespace
}  // namespace kiln::test
