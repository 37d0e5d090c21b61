// A simulated clock drives the watch, so that each answer is known to the second.
#include "cluster/rank_watch.h"

#include <gtest/gtest.h>

#include <string>

#include "base/process.h"
#include "base/work_count.h"

namespace kiln::test {
namespace {
using std::chrono::milliseconds;

class RankWatchTest : public ::testing::Test {
 protected:
  static constexpr double kLimit_s = 10;
  RankWatch::Clock::time_point now_ = RankWatch::Clock::now();
  RankWatch watch_{0, 3, kLimit_s, {}, now_};

  // Advances the clock as the service loop does. Ranks 1 and 2 send pulses with their idle times; a negative time sends
  // no pulse.
  void pass(double seconds, double idle_of_1, double idle_of_2) {
    for (int step = 0; step < static_cast<int>(seconds * 2); ++step) {
      now_ += milliseconds(500);
      watch_.ownPulse(now_);
      if (idle_of_1 >= 0) watch_.onPulse(1, pulse(idle_of_1), now_);
      if (idle_of_2 >= 0) watch_.onPulse(2, pulse(idle_of_2), now_);
    }
  }
  static Pulse pulse(double idle_s, int last = 0) { return {idle_s, last, "node"}; }
  std::string silent() { return watch_.silentRanks(now_); }
};

TEST_F(RankWatchTest, ARankWithoutPulses_isNamedAfterTheLimit) {
  pass(1, 0, 0);
  pass(9, 0, -1);
  EXPECT_EQ(silent(), "");
  pass(2, 0, -1);
  EXPECT_EQ(
      silent(),
      "rank 2 on node has not answered for 11 s; it is stopped, or its machine or network is gone; --rank-timeout "
      "10 ends the run");
}

TEST_F(RankWatchTest, ARankWhoseDiskDoesNotAnswer_isNamedByItsIdleTime) {
  pass(20, 9, 0);
  EXPECT_EQ(silent(), "");
  pass(1, 12, 0);
  EXPECT_NE(silent().find("rank 1 on node has not read, written or computed for 12 s"), std::string::npos) << silent();
}

TEST_F(RankWatchTest, ARankThatHasEnded_isNotWatched) {
  watch_.onPulse(1, pulse(0, 1), now_);
  pass(20, -1, 0);
  EXPECT_EQ(silent(), "");
  EXPECT_FALSE(watch_.allEnded());
  watch_.onPulse(2, pulse(0, 1), now_);
  EXPECT_TRUE(watch_.allEnded());
}

TEST_F(RankWatchTest, AWholeJobThatIsSuspended_isNotEnded) {
  pass(1, 0, 0);
  now_ += std::chrono::hours(1);
  watch_.ownPulse(now_);
  EXPECT_EQ(silent(), "");
}

TEST_F(RankWatchTest, ItsOwnIdleTime_countsSinceTheLastReadOrWait) {
  double idle_s = 0;
  const auto beat = [&] {
    now_ += milliseconds(1000);
    if (const auto own = watch_.ownPulse(now_)) idle_s = own->idle_s;
  };
  beat();
  for (int i = 0; i < 5; ++i) beat();
  EXPECT_NEAR(idle_s, 5, 1.1);
  countWork();
  beat();
  EXPECT_EQ(idle_s, 0);
  beat();
  EXPECT_NEAR(idle_s, 1, 0.01);
  watch_.noteWaiting();
  beat();
  EXPECT_EQ(idle_s, 0);
}

// A rank that waits for a program, such as an encoder of videos, is not reported.
TEST(RankWatchWork, CountsAWaitForAnotherProcessAsWork) {
  const std::uint64_t before = workCount();
  EXPECT_TRUE(outputOf("/bin/sleep", {"0.3"}, 1, [] {}));
  EXPECT_GT(workCount(), before);
}

}  // namespace
}  // namespace kiln::test
