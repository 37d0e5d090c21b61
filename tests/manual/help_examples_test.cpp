// Known: each example of each command's help ends with exit code 0. The lines run in one folder, which has the files
// that examples read; commands that make files for others come first.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "base/file/file.h"
#include "support/system/run_script.h"
#include "support/system/run_tool.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

// The commands in the order in which their examples run.
const std::vector<std::string>& commands() {
  static const std::vector<std::string> names = {"convert", "render",  "info",  "verify", "export",
                                                 "slice",   "gallery", "tf",    "split",  "composite",
                                                 "compare", "schema",  "bench", "manual", "view"};
  return names;
}

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) out.push_back(line);
  return out;
}

// Returns the lines of help from EXAMPLES on.
std::string examplesOf(const std::string& command) {
  const std::string help = runTool({command, "--help"}).out;
  const std::size_t at = help.find("\nEXAMPLES\n");
  return at == std::string::npos ? "" : help.substr(at + std::string("\nEXAMPLES\n").size());
}

// The viewer runs until a signal ends it. Without --foreground, timeout sends the signal twice, and the second ends the
// viewer at once.
std::string viewed() {
  std::string out;
  for (const std::string& line : linesOf(examplesOf("view")))
    if (!line.empty())
      out += "timeout --foreground --preserve-status -s INT 4 " + line.substr(line.find("kiln")) + "\n";
  return out;
}

TEST(HelpExamples, EveryCommand_hasSome) {
  const std::vector<std::string> help = linesOf(runTool({"--help"}).out);
  const auto first = std::find(help.begin(), help.end(), "Subcommands:");
  ASSERT_NE(first, help.end());
  for (auto line = first + 1; line != help.end() && line->starts_with("  "); ++line) {
    std::istringstream words(*line);
    std::string name;
    words >> name;
    if (line->size() > 2 && (*line)[2] == ' ') continue;  // a description goes on
    EXPECT_NE(std::find(commands().begin(), commands().end(), name), commands().end()) << name;
  }
  for (const std::string& command : commands())
    EXPECT_NE(examplesOf(command).find("  kiln " + command + " "), std::string::npos) << command;
}

TEST(HelpExamples, Lines_endWithoutError) {
  const fs::path directory = freshDirectory("help_examples"), work = directory / "work";
  fs::create_directory(work);
  writeText(work / "scan.nrrd",
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 3 4\nencoding: raw\n\n" + std::string(24, 'x'));
  writeText(work / "rock.raw", std::string(4096, '\177'));
  writeText(
      work / "suite.json",
      R"({"kiln_suite": 1, "title": "Head", "cases": [{"name": "head", "volume": "head.kiln", "sizes": [[32, 32]]}]})");
  std::string script;
  for (const std::string& command : commands()) script += command == "view" ? viewed() : examplesOf(command);
  runScript(directory, script);
  EXPECT_TRUE(fs::exists(work / "turn.png"));
  EXPECT_TRUE(fs::exists(work / "share/man/man1/kiln-render.1"));
  EXPECT_NE(readTextFile(work / "share/man/man1/kiln-render.1").find(".SH EXAMPLES\n.nf\n  kiln render head.kiln"),
            std::string::npos);
}

}  // namespace
}  // namespace kiln::test
