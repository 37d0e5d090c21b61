// Ranks run as threads and compare facts; the test itself makes the differences.
#include <gtest/gtest.h>

#include "base/error.h"
#include "cluster/agreement.h"
#include "support/system/thread_ranks.h"

namespace kiln::test {
namespace {

std::string errorOf(const std::function<std::vector<RankFact>(int rank)>& facts) {
  try {
    runRanks(3, [&](Ranks& ranks) {
      const std::vector<RankFact> own = facts(ranks.rank());
      requireAgreement(ranks, own);
    });
  } catch (const Error& error) {
    EXPECT_EQ(error.exitCode(), 1);
    return error.what();
  }
  return "";
}

TEST(Agreement, EqualFacts_pass) {
  EXPECT_EQ(errorOf([](int) { return std::vector<RankFact>{{"a", "1"}, {"b", ""}}; }), "");
}

TEST(Agreement, AnotherValue_namesRankHostAndBothValues) {
  const std::string error = errorOf([](int rank) {
    return std::vector<RankFact>{{"a", "1"}, {"--size", rank == 2 ? "9x9" : "8x8"}};
  });
  EXPECT_EQ(error.find("rank 2 on "), 0u) << error;
  EXPECT_NE(error.find("--size is 9x9 there and 8x8 here"), std::string::npos) << error;
}

TEST(Agreement, AFactThatIsMissing_isADifference) {
  const std::string error = errorOf([](int rank) {
    std::vector<RankFact> out = {{"a", "1"}};
    if (rank != 1) out.push_back({"frame 2", "x"});
    return out;
  });
  EXPECT_NE(error.find("rank 1 on "), std::string::npos) << error;
}

}  // namespace
}  // namespace kiln::test
