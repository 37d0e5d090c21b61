// A frame drawn in tiles, stopped and resumed. Known because an uninterrupted frame has equal pixels, and its file
// equal bytes.
#include <gtest/gtest.h>

#include <filesystem>

#include "base/file/file.h"
#include "support/system/run_tool.h"
#include "support/system/sanitized.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

const fs::path& store() {
  static const fs::path made = makeStore(
      head({{48, 40, 36}, VoxelType::u8, obliqueAffine()}, usualRange(VoxelType::u8)), "checkpoint_store", 16);
  return made;
}

// A frame of 3 x 2 tiles whose crop begins inside a tile.
std::vector<std::string> frameTo(const fs::path& out, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {"render", store().string(), "-o", out.string(), "--tf", "iso:120"};
  // The distance limits the time of a tile to a second.
  arguments.insert(arguments.end(), {"--size", "1400x1300", "--crop", "100,200,1200,800", "--zoom", "0.6"});
  arguments.insert(arguments.end(), {"--aov", "depth,normal"});
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

class Checkpoint : public ::testing::Test {
 protected:
  void SetUp() override { directory_ = freshDirectory("checkpoint"); }
  // Ctrl-C once a tile is there.
  ToolResult stopped(const std::vector<std::string>& more = {}) const {
    ToolOptions options;
    options.interrupt_when = [this] {
      std::error_code none;
      return fs::file_size(tiles(), none) > 100000 && !none;
    };
    std::vector<std::string> arguments = {"--checkpoint"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return runTool(frameTo(picture(), arguments), options);
  }
  fs::path picture() const { return directory_ / "frame.exr"; }
  fs::path tiles() const { return directory_ / "frame.exr.tiles"; }
  void expectWhole(const ToolResult& result) const {
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const fs::path whole = directory_ / "whole.exr";
    ASSERT_TRUE(fs::exists(whole) || runTool(frameTo(whole)).exit_code == 0);
    EXPECT_EQ(readFile(picture()), readFile(whole));
    EXPECT_FALSE(fs::exists(tiles()));
  }

  fs::path directory_;
};

TEST_F(Checkpoint, ChangesNoByteOfThePicture) {
  const ToolResult drawn = runTool(frameTo(picture(), {"--checkpoint"}));
  expectWhole(drawn);
}

TEST_F(Checkpoint, GoesOnFromTheTilesThatAreWhole) {
  const ToolResult first = stopped();
  ASSERT_TRUE(first.interrupted) << "drawn before it could be stopped";
  EXPECT_EQ(first.exit_code, 1);
  EXPECT_NE(first.err.find("of 6 tiles are kept in " + tiles().string()), std::string::npos) << first.err;
  EXPECT_FALSE(fs::exists(picture()));
  // A kill during a write leaves half a record behind the last whole record.
  FileSystem::real().appendFile(tiles(), std::vector<std::byte>(70000, std::byte{1}));
  const ToolResult second = runTool(frameTo(picture(), {"--checkpoint", "--resume"}));
  EXPECT_NE(second.err.find("of 6 tiles are finished already"), std::string::npos) << second.err;
  EXPECT_NE(second.err.find(tiles().string() + ": "), std::string::npos) << second.err;
  expectWhole(second);
}

TEST_F(Checkpoint, NeitherTakesNorReplacesTilesOfAnotherFrame) {
  ASSERT_TRUE(stopped({"--azimuth", "40"}).interrupted);
  const auto kept = readFile(tiles());
  for (const std::vector<std::string>& how :
       std::vector<std::vector<std::string>>{{"--checkpoint", "--resume"}, {"--checkpoint"}}) {
    const ToolResult other = runTool(frameTo(picture(), how));
    EXPECT_EQ(other.exit_code, 1);
    EXPECT_NE(other.err.find(tiles().string() + ": has tiles of another picture"), std::string::npos) << other.err;
    EXPECT_EQ(readFile(tiles()), kept);
  }
  FileSystem::real().writeAtomic(tiles(), "the user's own");
  EXPECT_EQ(runTool(frameTo(picture(), {"--checkpoint"})).exit_code, 1);
  EXPECT_EQ(readTextFile(tiles()), "the user's own");
  fs::remove(tiles());
  expectWhole(runTool(frameTo(picture(), {"--checkpoint", "--resume"})));
}

TEST_F(Checkpoint, IsNeitherTakenNorLostUnasked) {
  ASSERT_TRUE(stopped().interrupted);
  const auto kept = readFile(tiles());
  const ToolResult refused = runTool(frameTo(picture(), {"--checkpoint"}));
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find(tiles().string() + ": "), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("--resume"), std::string::npos) << refused.err;
  EXPECT_EQ(readFile(tiles()), kept);
  fs::remove(tiles());
  expectWhole(runTool(frameTo(picture(), {"--checkpoint"})));
}

TEST_F(Checkpoint, IsRefusedWherePixelsWouldDependOnIt) {
  for (const std::vector<std::string>& more :
       std::vector<std::vector<std::string>>{{"--visibility", "quadtree"}, {"--skip-damaged"}, {"--repeat", "2"}}) {
    std::vector<std::string> arguments = {"--checkpoint"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ToolResult refused = runTool(frameTo(picture(), arguments));
    EXPECT_EQ(refused.exit_code, 2) << more.front();
    EXPECT_NE(refused.err.find("--checkpoint"), std::string::npos) << refused.err;
  }
}

// The picture alone takes 88 MiB in memory. Its tiles are on disk, and the file is written from the tiles band by band.
TEST_F(Checkpoint, APosterLargerThanTheBudgetIsDrawnWithinIt) {
  for (const std::string name : {"p.png", "p.exr"}) {
    const auto drawn = [&](const std::string& memory, const fs::path& to, bool kept) {
      std::vector<std::string> arguments = {
          "render",   store().string(), "-o",        to.string(), "--tf",         "iso:120",
          "--zoom",   "0.15",           "--size",    "2400x2400", "--threads",    "2",
          "--memory", memory,           "--samples", "1",         "--background", "0.1,0.2,0.3"};
      if (kept) arguments.emplace_back("--checkpoint");
      return runTool(arguments, {.fresh = true});
    };
    EXPECT_EQ(drawn("44M", directory_ / name, false).exit_code, 1) << "the picture fits";
    const ToolResult poster = drawn("44M", directory_ / name, true);
    ASSERT_EQ(poster.exit_code, 0) << poster.err;
    if (!kSanitized) {
      EXPECT_LE(poster.peak_resident_bytes, (44ull + 50) << 20) << name;
    }
    ASSERT_EQ(drawn("2G", directory_ / ("whole_" + name), false).exit_code, 0);
    EXPECT_TRUE(readFile(directory_ / name) == readFile(directory_ / ("whole_" + name))) << name;
  }
}

}  // namespace
}  // namespace kiln::test
