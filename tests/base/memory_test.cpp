// Parsing of memory sizes with suffixes; results are powers of 1024 by definition.
#include "base/memory/memory.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "support/system/expect_error.h"

namespace kiln {
namespace {

TEST(ParseBytes, KnowsTheUsualUnits) {
  EXPECT_EQ(parseBytes("0"), 0u);
  EXPECT_EQ(parseBytes("123"), 123u);
  EXPECT_EQ(parseBytes("4K"), 4096u);
  EXPECT_EQ(parseBytes("32M"), 32u << 20);
  EXPECT_EQ(parseBytes("32MiB"), 32u << 20);
  EXPECT_EQ(parseBytes("1.5g"), 3ull << 29);
  EXPECT_EQ(parseBytes("2GB"), 2ull << 30);
  EXPECT_EQ(parseBytes("3T"), 3ull << 40);
}

TEST(ParseBytes, RefusesTheRestByName) {
  for (const char* text : {"", "M", "12X", "-1", "nan", "1e30T", "2 G", "G2"}) {
    test::expectError([&] { parseBytes(text); }, ErrorCode::kUsage, "'" + std::string(text) + "'");
  }
}

TEST(FormatBytes, HasAUnitAlways) {
  EXPECT_EQ(formatBytes(17), "17 bytes");
  EXPECT_EQ(formatBytes(32ull << 20), "32.0 MiB");
  EXPECT_EQ(formatBytes(3ull << 29), "1.50 GiB");
}

TEST(RoundedUpBytes, AsksForNoLess) {
  EXPECT_EQ(roundedUpBytes(1), "1M");
  EXPECT_EQ(roundedUpBytes(32u << 20), "32M");
  EXPECT_EQ(roundedUpBytes((32u << 20) + 1), "33M");
}

}  // namespace
}  // namespace kiln
