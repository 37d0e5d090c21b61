// Words of the command line for people: help by command, proposals for options of other programs, durations.
#include <gtest/gtest.h>

#include "support/system/run_tool.h"

namespace kiln::test {
namespace {

TEST(Words, HelpOfACommand_isThatOfItsOption) {
  const ToolResult help = runTool({"help", "slice"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_EQ(help.out, runTool({"slice", "--help"}).out);
  EXPECT_NE(help.out.find("--colormap"), std::string::npos);
  EXPECT_EQ(runTool({"help"}).out, runTool({"--help"}).out);
}

TEST(Words, UnknownOption_proposesAnOptionOfTheCommand) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"render", "a.kiln", "--bg", "white"}, "kiln: --bg: is no option of kiln render; --background?"},
      {{"render", "a.kiln", "--resolution=4x4"}, "kiln: --resolution: is no option of kiln render; --size?"},
      {{"render", "a.kiln", "--sampels", "4"}, "kiln: --sampels: is no option of kiln render; --samples?"},
      {{"render", "a.kiln", "--fps", "30"}, "kiln: --fps: is no option of kiln render; --rate?"},
      {{"slice", "a.kiln", "-o", "a.png", "--color", "fire"}, "kiln: --color: is no option of kiln slice; --colormap?"},
      {{"verify", "a.kiln", "--quux"}, "kiln: --quux: is no option of kiln verify; run 'kiln verify --help'"}};
  for (const auto& [arguments, expected] : cases) {
    const ToolResult result = runTool(arguments);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.err, expected + "\n");
  }
}

}  // namespace
}  // namespace kiln::test
