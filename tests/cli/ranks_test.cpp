// Several ranks under mpirun are one program: what they print, how they end. Skipped where Kiln is built without MPI or
// mpirun is not there.
#include <gtest/gtest.h>

#include <filesystem>

#include "support/run_tool.h"
#include "support/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class Ranks : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!canRunRanks()) GTEST_SKIP() << "Kiln is built without MPI, or mpirun is not there";
  }
  static ToolResult run(int ranks, const std::vector<std::string>& arguments) {
    ToolOptions options;
    options.ranks = ranks;
    return runTool(arguments, options);
  }
};

TEST_F(Ranks, OneOfThemSpeaks) {
  EXPECT_EQ(run(3, {"--version"}).out, runTool({"--version"}).out);
  const fs::path store =
      makeStore(head({{20, 20, 20}, VoxelType::u8, obliqueAffine()}, usualRange(VoxelType::u8)), "ranks_info", 8);
  const ToolResult info = run(3, {"info", store.string()});
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_EQ(info.out, runTool({"info", store.string()}).out);
}

// mpirun adds sentences of its own about the exit code.
TEST_F(Ranks, OneSentenceSaysWhatFailed) {
  const auto said = [](const ToolResult& result) {
    int out = 0;
    for (const std::string& line : result.errorLines()) out += line.starts_with("kiln:") ? 1 : 0;
    return out;
  };
  const ToolResult missing = run(3, {"info", "/nowhere.kiln"});
  EXPECT_EQ(missing.exit_code, 1) << missing.err;
  EXPECT_EQ(said(missing), 1) << missing.err;
  EXPECT_NE(missing.err.find("kiln: rank 0 of 3: /nowhere.kiln"), std::string::npos) << missing.err;
  const ToolResult wrong = run(3, {"info", "--sideways"});
  EXPECT_EQ(wrong.exit_code, 2) << wrong.err;
  EXPECT_EQ(said(wrong), 1) << wrong.err;
}

}  // namespace
}  // namespace kiln::test
