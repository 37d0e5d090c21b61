// `kiln bench` as its users see it: printed text, written files, and refusal to overwrite other files.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/file/file.h"
#include "support/system/run_tool.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

class Bench : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ = freshDirectory("bench");
    const DenseVolume volume = head({{32, 32, 28}, VoxelType::u8}, {0, 255});
    writeText(directory_ / "head.raw", {reinterpret_cast<const char*>(volume.voxels.data()), volume.voxels.size()});
    writeText(directory_ / "head.nhdr",
              "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 32 32 28\nencoding: raw\ndata file: head.raw\n");
    writeText(directory_ / "suite.json", R"({"kiln_suite": 1, "views": 2, "repeat": 1, "epsilon_px": [0, 4],
      "cost": {"sizes": [64], "areas": [8]},
      "cases": [{"name": "HEAD", "paper": "HEAD", "volume": "head.nhdr", "sizes": [[64, 64]], "node_slice": {},
                 "artifacts": true}]})");
  }
  std::string in(const std::string& name) const { return (directory_ / name).string(); }

  fs::path directory_;
};

// Known because a case has five methods in two projections of two views, and the page is the last thing written.
TEST_F(Bench, WritesAReportAndUsesItsStoresAgain) {
  const ToolResult result = runTool({"bench", in("suite.json"), "-o", in("report")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* says : {"HEAD 64x64 orthographic", "range-tree", "over octree only", "report.html"})
    EXPECT_NE(result.out.find(says), std::string::npos) << result.out;
  const Json json = Json::parse(readTextFile(in("report/report.json")));
  EXPECT_EQ(json["runs"].size(), 2u);
  EXPECT_EQ(json["runs"][0]["frames"].size(), 10u);
  EXPECT_GT(json["volumes"][0]["convert_s"], 0.0);
  EXPECT_TRUE(fs::exists(in("report/report.html")));
  // Earlier pictures are removed; other files beside them stay.
  writeText(in("report/pictures/holiday.png"), "mine");
  writeText(in("report/pictures/picture-07-OTHER-orthographic.png"), "of an earlier suite");
  const ToolResult again = runTool({"bench", in("suite.json"), "-o", in("report"), "--quick"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(Json::parse(readTextFile(in("report/report.json")))["volumes"][0]["convert_s"], 0.0);
  EXPECT_EQ(readTextFile(in("report/pictures/holiday.png")), "mine");
  EXPECT_FALSE(fs::exists(in("report/pictures/picture-07-OTHER-orthographic.png")));
}

// Known because none of these suites can be measured, and files of other origin are not touched.
TEST_F(Bench, RefusesWhatItCannotDo) {
  const auto refused = [&](const std::vector<std::string>& arguments, int exit_code, const std::string& mention) {
    const ToolResult result = runTool(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_EQ(result.errorLines().size(), 1u) << result.err;
    EXPECT_NE(result.err.find(mention), std::string::npos) << result.err;
    EXPECT_EQ(result.out, "");
  };
  refused({"bench", in("suite.json")}, 2, "--output");
  refused({"bench", in("none.json"), "-o", in("report")}, 1, "none.json");
  fs::create_directory(in("mine"));
  writeText(in("mine/thesis.tex"), "years of work");
  refused({"bench", in("suite.json"), "-o", in("mine")}, 1, "thesis.tex");
  EXPECT_EQ(readTextFile(in("mine/thesis.tex")), "years of work");
  refused({"bench", in("suite.json"), "-o", in("suite.json")}, 2, "suite.json");
  writeText(in("wrong.json"), R"({"kiln_suite": 1, "cases": [{"name": "A", "volume": "none.nrrd", "colour": 1}]})");
  refused({"bench", in("wrong.json"), "-o", in("report")}, 2, "colour");
  writeText(in("absent.json"), R"({"kiln_suite": 1, "cases": [{"name": "A", "volume": "none.nrrd"}]})");
  refused({"bench", in("absent.json"), "-o", in("report")}, 1, "none.nrrd");
  EXPECT_FALSE(fs::exists(in("report/report.html")));
}

}  // namespace
}  // namespace kiln::test
