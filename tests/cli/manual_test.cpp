// Runs the examples of README and manual. Known: an example exits with 0 if its input files exist.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <regex>
#include <set>
#include <sstream>

#include "base/file.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class ManualCli : public ToolTest {
 protected:
  ManualCli() : ToolTest("manual_") {}

  // The command lines in blocks of code without a language.
  static std::vector<std::string> examplesIn(const fs::path& page) {
    std::vector<std::string> out;
    std::istringstream lines(readTextFile(page));
    bool inside = false, plain = false;
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("```")) {
        plain = !inside && line == "```";
        inside = !inside;
      } else if (inside && plain && line.starts_with("kiln ")) {
        out.push_back(line.substr(0, line.find(" #")));
      }
    }
    return out;
  }

  // Returns the example with a size that takes no time.
  static std::string small(std::string line) {
    const auto replace = [&](const char* pattern, const std::string& text) {
      line = std::regex_replace(line, std::regex(pattern), text);
    };
    replace("--size [0-9]+x[0-9]+", "--size 64x48");
    replace("--crop [0-9,]+", "--crop 8,8,16,16");
    replace("--turntable [0-9]+", "--turntable 2");
    replace("--index [0-9]+", "--index 6");
    replace("--repeat [0-9]+", "--repeat 2");
    if (line.starts_with("kiln render") && line.find("--size") == std::string::npos) line += " --size 64x48";
    return line;
  }

  // Returns true if all inputs of the line exist in the folder.
  bool namesWhatIsThere(const std::string& line) const {
    const std::regex input("[A-Za-z_0-9*/]+\\.(kiln|nrrd|nii\\.gz|json|exr|txt|vdb|mhd|raw)|[a-z_]+/");
    std::istringstream words(line);
    std::string word, before;
    while (words >> word) {
      const bool output = before == "-o" || before == "--stats" || before == "--trace" || before == ">";
      if (!output && std::regex_match(word, input) && !fs::exists(in(word))) return false;
      before = word;
    }
    return true;
  }
};

TEST_F(ManualCli, Examples_run) {
  done({"convert", "phantom:head:40x40x40", in("head.kiln"), "--brick-size", "16"});
  fs::copy(in("head.kiln"), in("ct.kiln"), fs::copy_options::recursive);
  fs::copy(in("head.kiln"), in("scan.kiln"), fs::copy_options::recursive);
  std::string labels(8 * 8 * 8, '\0');
  for (std::size_t i = 200; i < 300; ++i) labels[i] = static_cast<char>(1 + i % 2);
  const std::string header = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 8 8 8\nencoding: raw\n\n";
  writeText(in("organs.nrrd"), header + labels);
  writeText(in("head.nrrd"), header + labels);
  done({"convert", in("organs.nrrd"), in("organs.kiln"), "--labels"});
  writeText(in("job.json"), R"({"kiln": 1, "volume": "head.kiln", "output": "job_####.png", "frames": "1-2",
    "camera": {"turntable": {"frames": 2}}})");
  std::vector<fs::path> pages{fs::path(KILN_SOURCE_DIR) / "README.md"};
  for (const auto& page : fs::directory_iterator(fs::path(KILN_SOURCE_DIR) / "tools/kiln/manual"))
    pages.push_back(page.path());
  std::sort(pages.begin() + 1, pages.end());
  const std::string enter =
      fmt::format("cd '{}' && PATH='{}':$PATH && ", in(""), fs::path(KILN_TOOL).parent_path().string());
  std::set<std::string> run;
  for (const fs::path& page : pages) {
    for (const std::string& example : examplesIn(page)) {
      const std::string line = small(example);
      const bool too_long =
          line.find("--samples 16") != std::string::npos || line.find("phantom:body") != std::string::npos ||
          line.find("equirectangular") != std::string::npos || line.find(".mp4") != std::string::npos ||
          line.find("--frames 1-100") != std::string::npos || line.find("kiln split") == 0;
      if (too_long || !namesWhatIsThere(line) || !run.insert(line).second) continue;
      const std::string log = in("log.txt");
      EXPECT_EQ(std::system((enter + line + " >'" + log + "' 2>&1").c_str()), 0)
          << page.filename() << ": " << line << "\n"
          << readTextFile(log);
    }
  }
  EXPECT_GE(run.size(), 35u) << "the examples were not found";
}

}  // namespace
}  // namespace kiln::test
