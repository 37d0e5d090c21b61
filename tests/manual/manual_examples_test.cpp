// Known: the examples of README and manual end with exit code 0. A block of code that opens with "```sh run" is an
// example; the names of further programs that the block needs follow. A block that opens with "```json NAME" becomes
// the file NAME. The blocks of a page run in order, in a folder of the page.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "base/file/file.h"
#include "support/system/run_script.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

fs::path pathOfPage(const std::string& name) {
  const fs::path source = KILN_SOURCE_DIR;
  return name == "README" ? source / "README.md" : source / "tools/kiln/manual" / (name + ".md");
}

struct FencedBlock {
  std::vector<std::string> info;  // the words after the fence
  std::string text;
  int line = 0;  // of the fence, from 1 on
  bool isExample() const { return info.size() >= 2 && info[0] == "sh" && info[1] == "run"; }
  bool isFile() const { return info.size() == 2 && info[0] == "json"; }
};

std::vector<FencedBlock> fencedBlocks(const std::string& page) {
  std::vector<FencedBlock> blocks;
  std::istringstream in(page);
  bool inside = false;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.starts_with("```")) {
      inside = !inside;
      if (!inside) continue;
      blocks.emplace_back().line = number;
      std::istringstream words(line.substr(3));
      for (std::string word; words >> word;) blocks.back().info.push_back(word);
    } else if (inside) {
      blocks.back().text += line + '\n';
    }
  }
  EXPECT_FALSE(inside) << "a fence is not closed";
  return blocks;
}

std::vector<std::string> pageNames() {
  std::vector<std::string> names{"README"};
  for (const auto& entry : fs::directory_iterator(pathOfPage("convert").parent_path()))
    if (entry.path().extension() == ".md") names.push_back(entry.path().stem().string());
  std::sort(names.begin() + 1, names.end());
  return names;
}

bool isInstalled(const std::string& program) {
  return std::system(("command -v " + program + " > /dev/null").c_str()) == 0;
}

class ManualExamples : public testing::TestWithParam<std::string> {
 protected:
  void run(const FencedBlock& block) {
    SCOPED_TRACE(pathOfPage(GetParam()).string() + ":" + std::to_string(block.line));
    runScript(directory_, block.text);
  }

  void SetUp() override {
    directory_ = freshDirectory("manual_" + GetParam());
    fs::create_directory(directory_ / "work");
  }

  fs::path directory_;
};

TEST_P(ManualExamples, Blocks_endWithoutError) {
  std::string absent;
  for (const FencedBlock& block : fencedBlocks(readTextFile(pathOfPage(GetParam())))) {
    if (block.isFile()) writeText(directory_ / "work" / block.info[1], block.text);
    if (!block.isExample()) continue;
    const auto missing = std::find_if_not(block.info.begin() + 2, block.info.end(), isInstalled);
    if (missing != block.info.end()) {
      absent = *missing;
    } else {
      run(block);
    }
    if (HasFailure()) return;
  }
  if (!absent.empty()) GTEST_SKIP() << absent << " is not installed";
}

INSTANTIATE_TEST_SUITE_P(Pages, ManualExamples, testing::ValuesIn(pageNames()), [](const auto& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

// Known by hand: three blocks, of which the reader finds the words, the text and the line.
TEST(ManualBlocks, OpeningLine_namesKindFileAndPrograms) {
  const std::vector<FencedBlock> blocks =
      fencedBlocks("text\n```sh run oiiotool\nkiln a\nkiln b\n```\n```sh\nkiln c\n```\n```json x.json\n{}\n```\n");
  ASSERT_EQ(blocks.size(), 3u);
  EXPECT_TRUE(blocks[0].isExample());
  EXPECT_EQ(blocks[0].text, "kiln a\nkiln b\n");
  EXPECT_EQ(blocks[0].info, (std::vector<std::string>{"sh", "run", "oiiotool"}));
  EXPECT_EQ(blocks[0].line, 2);
  EXPECT_FALSE(blocks[1].isExample());
  EXPECT_TRUE(blocks[2].isFile());
  EXPECT_EQ(blocks[2].text, "{}\n");
}

// A page that loses its marks would pass without a run. The blocks of the pictures have a test of their own.
TEST(ManualBlocks, EveryPageButTwo_hasAnExample) {
  for (const std::string& name : pageNames()) {
    const std::vector<FencedBlock> blocks = fencedBlocks(readTextFile(pathOfPage(name)));
    EXPECT_EQ(std::any_of(blocks.begin(), blocks.end(), [](const FencedBlock& block) { return block.isExample(); }),
              name != "limits" && name != "pictures")
        << name;
  }
}

}  // namespace
}  // namespace kiln::test
