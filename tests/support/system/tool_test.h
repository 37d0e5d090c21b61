// A test that runs the program in a separate directory: expected results, and refusals with a one-line error.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "support/system/run_tool.h"
#include "support/volumes/test_store.h"

namespace kiln::test {

class ToolTest : public ::testing::Test {
 protected:
  /// `name` is the directory's, beside the test's own.
  explicit ToolTest(const std::string& name)
      : directory_(freshDirectory(name + ::testing::UnitTest::GetInstance()->current_test_info()->name())) {}

  std::string in(const std::string& name) const { return (directory_ / name).string(); }

  static ToolResult done(const std::vector<std::string>& arguments, const ToolOptions& options = {}) {
    const ToolResult result = runTool(arguments, options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result;
  }

  static void refused(const std::vector<std::string>& arguments, int exit_code, const std::string& mention) {
    const ToolResult result = runTool(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_EQ(result.errorLines().size(), 1u) << result.err;
    EXPECT_NE(result.err.find(mention), std::string::npos) << "'" << mention << "' is not in: " << result.err;
  }

  const std::filesystem::path directory_;
};

}  // namespace kiln::test
