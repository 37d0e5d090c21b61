// Statistics of many frames. Known: a sequence of any length keeps numbers, and no lists of bricks.
#include <gtest/gtest.h>

#include "frame/statistics.h"

namespace kiln::test {
namespace {

TEST(RenderStatistics, Frames_keepNoListsOfBricks) {
  FrameStatistics frame;
  frame.addContributing({{0, {1, 2, 3}}}, 500);
  frame.damaged.insert({{0, {1, 2, 4}}});
  frame.bricks_damaged = 1;
  RenderStatistics all;
  all.add(frame);
  EXPECT_TRUE(all.frames.front().contributing.empty());
  EXPECT_TRUE(all.frames.front().damaged.empty());
  EXPECT_EQ(all.frames.front().bricks_contributing, 1u);
  EXPECT_EQ(all.frames.front().bricks_contributing_bytes, 500u);
  EXPECT_EQ(all.frames.front().bricks_damaged, 1u);
}

}  // namespace
}  // namespace kiln::test
