// A volume of 128 MB of voxels draws within 32 MB, half of them image, and the picture is that of 2 GB: the promise in
// the first line of the README. The answer is the picture with more memory than the volume needs, and the peak that the
// operating system counted.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "support/foreign_files.h"
#include "support/run_tool.h"
#include "support/sanitized.h"
#include "support/test_store.h"

namespace kiln::test {
namespace {

namespace fs = std::filesystem;

nlohmann::json statisticsIn(const fs::path& path) { return nlohmann::json::parse(readTextFile(path)); }

TEST(MemoryBudget, ALargeHeadDrawsInThirtyTwoMegabytes) {
  const fs::path input = fs::path(KILN_TEST_DATA_DIR) / "vhm_head_512x512x245_i16le.nrrd";
  if (!fs::exists(input)) GTEST_SKIP() << input << " is not here; rendering beyond memory is not tested on real data";
  const fs::path directory = freshDirectory("memory_budget");
  const fs::path store = directory / "head.kiln";
  ASSERT_EQ(runTool({"convert", input, store}).exit_code, 0);
  const auto draw = [&](const std::string& memory) {
    const fs::path picture = directory / (memory + ".exr");
    const ToolResult result = runTool({"render", store, "-o", picture, "--size", "1024x1024", "--exr-type", "float",
                                       "--memory", memory, "--stats", directory / (memory + ".json")});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return readFile(picture);
  };
  EXPECT_EQ(draw("32M"), draw("2G"));
  const nlohmann::json statistics = statisticsIn(directory / "32M.json");
  const std::uint64_t budget = 32ull << 20;
  EXPECT_LE(statistics["memory"]["peak_cache_bytes"].get<std::uint64_t>() +
                statistics["memory"]["framebuffer_bytes"].get<std::uint64_t>() +
                statistics["memory"]["peak_slabs_bytes"].get<std::uint64_t>(),
            budget);
  EXPECT_EQ(statistics["memory"]["budget_bytes"], budget);
  std::printf("budget 32 MiB: peak cache %.1f MiB, peak resident %.1f MiB, image %.1f MiB\n",
              statistics["memory"]["peak_cache_bytes"].get<double>() / 1048576,
              statistics["memory"]["peak_rss_bytes"].get<double>() / 1048576,
              statistics["memory"]["framebuffer_bytes"].get<double>() / 1048576);
  // A sanitizer keeps what was freed and shadows every byte: its resident memory says nothing.
  if (!kSanitized) EXPECT_LT(statistics["memory"]["peak_rss_bytes"], budget + (80ull << 20));
  // Each visible brick is read once, however small the budget.
  EXPECT_EQ(statistics["bricks"]["read"], statisticsIn(directory / "2G.json")["bricks"]["read"]);
  fs::remove_all(directory);
}

// Nearer samples are more of them that wait for their slabs: flames over a head are the most that there are.
TEST(MemoryBudget, NearSamplesAreWithinTheirAccount) {
  const fs::path input = fs::path(KILN_TEST_DATA_DIR) / "cthead_256x256x113_u16le.nrrd";
  if (!fs::exists(input)) GTEST_SKIP() << input << " is not here; samples that wait are not counted on real data";
  const fs::path directory = freshDirectory("near_samples");
  const fs::path store = directory / "head.kiln";
  ASSERT_EQ(runTool({"convert", input, store, "--spacing", "1,1,2"}).exit_code, 0);
  for (const char* const voxels : {"0.25", "0.5"}) {
    const ToolResult result = runTool({"render", store, "-o", directory / "p.exr", "--size", "256x256", "--tf", "fire",
                                       "--projection", "perspective", "--zoom", "1.44", "--threads", "1",
                                       "--sample-distance", voxels, "--stats", directory / "s.json"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const nlohmann::json memory = statisticsIn(directory / "s.json")["memory"];
    EXPECT_LE(memory["peak_slabs_bytes"], memory["slabs_bytes"]) << voxels;
    EXPECT_GE(memory["peak_slabs_bytes"].get<double>(), 0.3 * memory["slabs_bytes"].get<double>()) << voxels;
  }
  fs::remove_all(directory);
}

// Every kind of picture and conversion against budgets. The answer is the budget and 50 MiB for the program itself and
// what the allocator keeps, as the system counts the process. A row that refuses the budget in one line is right, too.
struct BudgetRow {
  const char* name;
  std::vector<std::string> arguments;  // IN/ stands for the test's folder
};

const std::vector<BudgetRow>& budgetRows() {
  static const auto rendered = [](const char* name, std::vector<std::string> options, const char* file = "IN/o.exr") {
    options.insert(options.begin(), {"render", "IN/head.kiln", "-o", file, "--tf", "ct-bone-and-skin"});
    return BudgetRow{name, options};
  };
  static const auto converted = [](const char* name, const char* input, std::vector<std::string> options = {}) {
    options.insert(options.begin(), {"convert", input, "IN/c.kiln", "--overwrite"});
    return BudgetRow{name, options};
  };
  static const std::vector<BudgetRow> rows = {
      rendered("pixel lattice", {"--size", "500x500", "--samples", "1"}),
      rendered("rays", {"--size", "400x400", "--lattice", "ray", "--samples", "4"}),
      rendered("voxel lattice", {"--size", "400x400", "--lattice", "voxel", "--samples", "4"}),
      rendered("16 samples", {"--size", "120x120", "--samples", "16"}),
      rendered("depth and normals", {"--size", "400x400", "--samples", "1", "--aov", "depth,normal"}),
      rendered("16-bit PNG", {"--size", "900x900", "--samples", "1", "--png-bits", "16"}, "IN/o.png"),
      rendered("stereo EXR", {"--size", "250x250", "--samples", "1", "--stereo", "both", "--interocular", "20"}),
      rendered("stereo PNG", {"--size", "250x250", "--samples", "1", "--stereo", "both", "--interocular", "20"},
               "IN/o.png"),
      rendered("panorama", {"--size", "240x120", "--projection", "equirectangular"}),
      rendered("deep", {"--size", "150x150", "--deep"}),
      rendered("two volumes", {"--size", "150x150", "--samples", "1", "--add", "IN/head.kiln"}),
      rendered("partial image", {"--size", "200x200", "--part", "1/4"}),
      rendered("sequence", {"--size", "250x250", "--turntable", "3", "--samples", "1"}, "IN/o_#.png"),
      rendered("checkpoint", {"--size", "900x900", "--samples", "1", "--checkpoint"}),
      {"projected values", {"render", "IN/head.kiln", "-o", "IN/o.exr", "--mode", "mip", "--size", "500x500"}},
      {"slice", {"slice", "IN/head.kiln", "-o", "IN/o.png"}},
      converted("convert computed", "phantom:head:160x160x160"),
      converted("convert raw", "IN/head.raw", {"--dims", "160,160,160", "--type", "u16"}),
      converted("convert gzip", "IN/head.nrrd"),
      converted("convert OpenVDB", "IN/head.vdb"),
      {"projected values, large bricks",
       {"render", "IN/large.kiln", "-o", "IN/o.exr", "--mode", "mip", "--size", "500x500"}},
      converted("convert large OpenVDB", "IN/large.vdb"),
  };
  return rows;
}

class BudgetTable : public ::testing::Test {
 protected:
  void check(const std::vector<std::string>& names, const std::vector<int>& budgets) {
    if (kSanitized) GTEST_SKIP() << "a sanitizer shadows every byte, and its resident memory says nothing";
    const fs::path directory = freshDirectory("budget_table");
    makeInputs(directory);
    for (const BudgetRow& row : budgetRows()) {
      if (!names.empty() && std::find(names.begin(), names.end(), row.name) == names.end()) continue;
      for (const int budget : budgets) {
        std::vector<std::string> arguments = row.arguments;
        for (std::string& argument : arguments)
          if (argument.starts_with("IN/")) argument = (directory / argument.substr(3)).string();
        arguments.insert(arguments.end(), {"--memory", std::to_string(budget) + "M"});
        const ToolResult result = runTool(arguments);
        const auto peak = static_cast<double>(result.peak_resident_bytes) / (1 << 20);
        EXPECT_LE(peak, budget + 50.0) << row.name << " in " << budget << " MiB";
        if (result.exit_code == 0) continue;
        EXPECT_EQ(result.exit_code, 1) << row.name << ": " << result.err;
        EXPECT_NE(result.err.find("--memory"), std::string::npos) << row.name << ": " << result.err;
        EXPECT_EQ(result.errorLines().size(), 1u) << row.name << ": " << result.err;
      }
    }
    fs::remove_all(directory);
  }

 private:
  static void makeInputs(const fs::path& directory) {
    ASSERT_EQ(runTool({"convert", "phantom:head:160x160x160", directory / "head.kiln", "--brick-size", "64"}).exit_code,
              0);
    ASSERT_EQ(runTool({"export", directory / "head.kiln", directory / "head.vdb"}).exit_code, 0);
    // Bricks of 128 voxels have pages of their own, and the process keeps some of these pages.
    ASSERT_EQ(runTool({"convert", "phantom:head:288x288x288", directory / "large.kiln"}).exit_code, 0);
    ASSERT_EQ(runTool({"export", directory / "large.kiln", directory / "large.vdb"}).exit_code, 0);
    const std::vector<std::byte> voxels(160 * 160 * 160 * 2, std::byte{7});
    FileSystem::real().writeAtomic(directory / "head.raw", voxels);
    const std::string header =
        "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 160 160 160\nendian: little\nencoding: gzip\n\n";
    FileSystem::real().writeAtomic(directory / "head.nrrd",
                                   header + gzipped({reinterpret_cast<const char*>(voxels.data()), voxels.size()}));
  }
};

TEST_F(BudgetTable, TheUsualPicturesAndConversionsStayWithinIt) {
  check({"pixel lattice", "depth and normals", "slice", "convert raw", "convert gzip"}, {24});
}

TEST_F(BudgetTable, NightlyEveryPictureAndConversionStaysWithinIt) { check({}, {16, 24, 32, 48, 64, 128, 512, 1500}); }

}  // namespace
}  // namespace kiln::test
