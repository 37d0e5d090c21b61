#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "convert/write_behind.h"

namespace kiln {
namespace {

UnwrittenBrick numbered(std::int32_t n) { return {{{0, {n, 0, 0}}, {}, {}}, {}}; }

class WriteBehindOf : public ::testing::TestWithParam<std::size_t> {};

TEST_P(WriteBehindOf, WritesAllInOrder) {
  std::vector<std::int32_t> written;
  {
    WriteBehind disk(GetParam(), [&](const UnwrittenBrick& brick) { written.push_back(brick.brick.key.brick.x); });
    for (std::int32_t n = 0; n < 50; ++n) disk.add(numbered(n));
    disk.finish();
    EXPECT_EQ(written.size(), 50u);
    disk.add(numbered(50));  // written without a call of finish()
  }
  ASSERT_EQ(written.size(), 51u);
  for (std::int32_t n = 0; n < 51; ++n) EXPECT_EQ(written[static_cast<std::size_t>(n)], n);
}

TEST_P(WriteBehindOf, AFailureEndsItAndIsTold) {
  std::atomic<int> writes = 0;
  WriteBehind disk(GetParam(), [&](const UnwrittenBrick&) {
    if (++writes == 4) throw std::runtime_error("full");
  });
  EXPECT_THROW(
      {
        for (std::int32_t n = 0; n < 50; ++n) disk.add(numbered(n));
      },
      std::runtime_error);
  EXPECT_EQ(writes, 4);
  if (GetParam() > 0) {
    EXPECT_THROW(disk.finish(), std::runtime_error);
    EXPECT_THROW(disk.add(numbered(50)), std::runtime_error);
    EXPECT_EQ(writes, 4);
  }
}

INSTANTIATE_TEST_SUITE_P(Rooms, WriteBehindOf, ::testing::Values(0u, 1u, 3u));

}  // namespace
}  // namespace kiln
