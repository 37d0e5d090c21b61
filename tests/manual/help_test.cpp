// Generated descriptions of the program: schema, manual pages and completion come from the option tables and must
// agree. Every option has a test.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "base/file/file.h"
#include "support/system/run_python.h"
#include "support/system/run_tool.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

std::set<std::string> longOptionsOf(const std::string& text) {
  std::set<std::string> out;
  const std::regex option("--[a-z][a-z-]*");
  for (std::sregex_iterator it(text.begin(), text.end(), option), end; it != end; ++it) out.insert(it->str());
  return out;
}

std::string allTests() {
  std::string out;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(KILN_SOURCE_DIR) / "tests")) {
    if (entry.path().extension() == ".cpp") out += readTextFile(entry.path());
  }
  return out;
}

TEST(Help, EveryOptionOfRenderIsUsedByATest) {
  const std::string tests = allTests();
  for (const std::string& option : longOptionsOf(runTool({"render", "--help"}).out)) {
    if (option == "--help") continue;
    EXPECT_NE(tests.find('"' + option + '"'), std::string::npos) << option;
  }
}

// Known from another validator: the jobs of README and manual follow the printed schema.
TEST(Help, JobsOfReadmeAndManual_followTheSchema) {
  const fs::path directory = freshDirectory("help_schema");
  writeText(directory / "schema.json", runTool({"schema"}).out);
  const std::string check = R"(
import json, jsonschema, re, sys
schema = json.load(open(sys.argv[1]))
jsonschema.Draft202012Validator.check_schema(schema)
check = jsonschema.Draft202012Validator(schema)
jobs = re.findall(r'```json[^\n]*\n(\{ "kiln": 2, (?:"volume|"output).*?)```', open(sys.argv[2]).read(), re.S)
for job in jobs: check.validate(json.loads(re.sub(r'//.*', '', job)))
keys = [{}, {"volume": ""}, {"volume": "a", "camera": {"fvo": 3}}, {"volume": "a", "image": {"width": 0}},
        {"volume": "a", "lights": [{"kind": "sun"}]}, {"volume": "a", "frames": "1-"},
        {"volume": "a", "image": {"background": "#12345"}}, {"volume": "a", "kiln": 3},
        {"volume": "a", "memory": "2X"}, {"volume": "a", "image": {"background": "nav"}},
        {"volume": "a", "transferFunction": {"surfaces": [{"value": 1}], "points": [{"value": 1, "opacity": 1}]}},
        {"volume": "a", "transferFunction": {}}, {"volume": "a", "lights": [{"type": "point"}]}]
wrong = [{"kiln": 2, **job} for job in keys] + [{"volume": "a"}]
assert len(jobs) >= 5 and not any(check.is_valid(job) for job in wrong)
surfaces = {"surfaces": [{"value": 1}]}
right = [{"memory": memory} for memory in ("1g", "500m", "1e9", "2GiB", ".5G", "512")]
right += [{"transferFunction": surfaces}, {"image": {"background": "NAVY"}}, {"$schema": "kiln.json"},
          {"transferFunction": {"regions": [{"values": [0, 1], "gradients": [0, 1]}]}},
          {"lights": [{"type": "point", "position": [0, 0, 0]}]}]
for job in right: check.validate({"kiln": 2, "volume": "a", **job})
for format in 1, 2: check.validate({"kiln": format, "volume": "a", "image": {"background": "#12345a"}})
)";
  std::string documents = readTextFile(fs::path(KILN_SOURCE_DIR) / "README.md");
  for (const auto& page : fs::directory_iterator(fs::path(KILN_SOURCE_DIR) / "tools/kiln/manual")) {
    if (page.path().extension() == ".md") documents += readTextFile(page.path());
  }
  writeText(directory / "documents.md", documents);
  if (!runPython("jsonschema", directory, check,
                 {(directory / "schema.json").string(), (directory / "documents.md").string()}))
    GTEST_SKIP() << "python3-jsonschema is not installed";
}

TEST(Help, ManualPagesAndCompletionNameEveryOption) {
  const fs::path share = freshDirectory("help_manual");
  const ToolResult result = runTool({"manual", share.string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::string page = readTextFile(share / "man/man1/kiln-render.1");
  EXPECT_TRUE(page.starts_with(".TH kiln\\-render 1")) << page.substr(0, 60);
  page.erase(std::remove(page.begin(), page.end(), '\\'), page.end());
  const std::string script = readTextFile(share / "bash-completion/completions/kiln");
  for (const std::string& option : longOptionsOf(runTool({"render", "--help"}).out)) {
    EXPECT_NE(page.find(option), std::string::npos) << option;
    EXPECT_NE(script.find(option), std::string::npos) << option;
  }
  for (const char* command :
       {"convert", "info", "verify", "export", "slice", "gallery", "tf", "render", "compare", "bench"})
    EXPECT_TRUE(fs::exists(share / "man/man1" / (std::string("kiln-") + command + ".1"))) << command;
  // Calls the completion as bash does: with the words typed so far and the index of the current word.
  const auto completed = [&](const std::string& words, int at) {
    const std::string file = (share / "answer").string();
    const std::string command = "bash -c 'source " + (share / "bash-completion/completions/kiln").string() +
                                "; COMP_WORDS=(" + words + "); COMP_CWORD=" + std::to_string(at) +
                                "; _kiln; echo ${COMPREPLY[@]}' > " + file;
    EXPECT_EQ(std::system(command.c_str()), 0);
    return readTextFile(file);
  };
  EXPECT_EQ(completed("kiln ver", 1), "verify\n");
  EXPECT_EQ(completed("kiln render --turnt", 2), "--turntable\n");
  EXPECT_EQ(completed("kiln render --visibility ra", 3), "range-tree\n");
  // Options of one name have the words of their command.
  EXPECT_EQ(completed("kiln render --mode c", 3), "composite\n");
  EXPECT_EQ(completed("kiln slice --mode \"\"", 3), "average mip minip\n");
  EXPECT_EQ(completed("kiln slice --level \"\"", 3), "\n");
  EXPECT_EQ(completed("kiln export --background w", 3), "\n");
  EXPECT_EQ(completed("kiln slice --axis co", 3), "coronal\n");
  EXPECT_EQ(completed("kiln slice --colormap vi", 3), "viridis\n");
  EXPECT_EQ(completed("kiln convert --type i1", 3), "i16\n");
  EXPECT_EQ(completed("kiln export --type \"\"", 3), "float half\n");
  EXPECT_EQ(completed("kiln render --add-tf ct-b", 3), "ct-bone ct-bone-and-skin\n");
  EXPECT_EQ(completed("kiln render --progress j", 3), "json\n");
  EXPECT_EQ(completed("kiln view --look \"\"", 3), "plain studio\n");
  EXPECT_EQ(completed("kiln gallery --look s", 3), "studio\n");
  EXPECT_EQ(completed("kiln composite --compression zi", 3), "zips zip\n");
  EXPECT_NE(readTextFile(share / "man/man1/kiln-slice.1").find("\\-\\-axis\\fR \\fITEXT\\fR=z\n"), std::string::npos);
}

}  // namespace
}  // namespace kiln::test
