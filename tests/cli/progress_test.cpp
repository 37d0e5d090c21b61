// Progress of a long frame: a line redrawn in place on a terminal, events for machines. The test interrupts the frame
// after enough output, so that no test waits for the end.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
using Json = nlohmann::json;

class ProgressCli : public ToolTest {
 protected:
  ProgressCli() : ToolTest("progress_") {}
  void SetUp() override { done({"convert", "phantom:head:60x60x60", in("h.kiln"), "--brick-size", "16"}); }

  // Interrupts a frame that would take many seconds; no file of the frame remains.
  ToolResult interrupted(const std::vector<std::string>& more, const ToolOptions& options) const {
    std::vector<std::string> words = {"render",  in("h.kiln"), "-o", in("f_#.exr"), "--size", "2000x2000", "--tf",
                                      "ct-skin", "--samples",  "16", "--view",      "front",  "--threads", "1"};
    words.insert(words.end(), more.begin(), more.end());
    const ToolResult result = runTool(words, options);
    EXPECT_TRUE(result.interrupted);
    EXPECT_EQ(result.exit_code, 1) << result.err;
    EXPECT_FALSE(std::filesystem::exists(in("f_1.exr")));
    return result;
  }
};

std::size_t countOf(const std::string& text, const std::string& part) {
  std::size_t out = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++out;
  return out;
}

TEST_F(ProgressCli, EventsSayHowFarAFrameIs) {
  ToolOptions options;
  options.interrupt_at = [](const ToolResult& result) { return countOf(result.out, "frame_progress") >= 2; };
  const ToolResult result = interrupted({"--progress", "json", "--turntable", "2"}, options);
  std::vector<Json> progress;
  std::istringstream lines(result.out);
  std::vector<std::string> names;
  for (std::string line; std::getline(lines, line);) {
    const Json event = Json::parse(line);
    names.push_back(event.at("event"));
    if (names.back() == "frame_progress") progress.push_back(event);
  }
  ASSERT_GE(progress.size(), 2u);
  EXPECT_EQ(names[0], "started");
  EXPECT_EQ(names[1], "frame_started");
  EXPECT_EQ(names.back(), "interrupted");
  for (std::size_t i = 0; i < progress.size(); ++i) {
    EXPECT_EQ(progress[i].at("frame"), 1);
    EXPECT_EQ(progress[i].at("unit"), "bricks");
    EXPECT_EQ(progress[i].at("total"), progress[0].at("total"));
    EXPECT_LE(progress[i].at("done"), progress[i].at("total"));
    EXPECT_GE(progress[i].at("done"), progress[i - std::min<std::size_t>(i, 1)].at("done"));
    if (progress[i].at("done") > 0) {
      EXPECT_GE(progress[i].at("seconds_left"), 0);
    }
  }
  EXPECT_EQ(result.errorLines().size(), 1u) << result.err;
}

// Known because \r and "erase to the end of the line" redraw a line, and a line of the terminal's full width would
// wrap.
TEST_F(ProgressCli, OnATerminalALineIsDrawnOver) {
  ToolOptions options;
  options.terminal_columns = 60;
  options.interrupt_at = [](const ToolResult& result) { return countOf(result.err, "bricks/s") >= 2; };
  const ToolResult result = interrupted({}, options);
  const std::regex line("\r\033\\[K(frame 1: ([0-9]+) % of [^\r\033]*)");
  int last = 0, seen = 0;
  for (std::sregex_iterator it(result.err.begin(), result.err.end(), line), end; it != end; ++it, ++seen) {
    EXPECT_LT((*it)[1].length(), 60) << (*it)[1];
    const int percent = std::stoi((*it)[2]);
    EXPECT_GE(percent, last);
    EXPECT_LT(percent, 100);
    last = percent;
  }
  EXPECT_GE(seen, 2) << result.err;
  EXPECT_NE(result.err.find(" left"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("\r\033[Kkiln: interrupted"), std::string::npos)
      << "the line is taken away: " << result.err;
}

}  // namespace
}  // namespace kiln::test
