// Time series: a shared camera and transfer function for all frames. Known because a growing body covers more pixels in
// each frame, and a frame's picture depends on no list of frames to draw.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/file/file.h"
#include "image/file/image_file.h"
#include "sequence/series_volumes.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class SeriesCli : public ToolTest {
 protected:
  SeriesCli() : ToolTest("series_") {}

  // A cube of `edge` voxels in a volume of the same size, denser in each frame, with a constant middle.
  void writeFrame(int frame) const {
    const int n = 8 * frame;
    const std::string voxels(static_cast<std::size_t>(n * n * n), static_cast<char>(40 * frame));
    std::string text = fmt::format(
        "NRRD0004\ntype: uchar\ndimension: 3\nsizes: {0} {0} {0}\nencoding: raw\nspace "
        "dimension: 3\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: "
        "({1},{1},{1})\n\n",
        n, 0.5 - n / 2.0);
    writeText(in(fmt::format("s_{:03}.nrrd", frame)), text + voxels);
  }
  void convert(int frame) const {
    writeFrame(frame);
    done({"convert", in(fmt::format("s_{:03}.nrrd", frame)), in(fmt::format("s_{:03}.kiln", frame))});
  }
  static std::size_t covered(const Image& image) {
    std::size_t out = 0;
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) out += image.rgba[i] > 0.5f ? 1 : 0;
    return out;
  }
  std::vector<std::string> drawing(const std::string& frames, const std::string& output,
                                   const std::string& volume = "s_###.kiln", const std::string& tf = "fire") const {
    return {"render", in(volume), "-o", in(output), "--frames", frames,       "--size",
            "48x48",  "--tf",     tf,   "--view",   "front",    "--exr-type", "float"};
  }
  Image image(const std::string& name) const { return readImage(in(name)); }
};

TEST_F(SeriesCli, GrowingBody_growsInThePictures) {
  for (const int frame : {1, 2, 3}) convert(frame);
  const ToolResult result = done(drawing("1-3", "a_#.exr", "s_###.kiln", "solid:20"));
  EXPECT_NE(
      result.err.find("one camera and one transfer function for all frames: by the boxes and values of frames 1-3"),
      std::string::npos)
      << result.err;
  const std::size_t first = covered(image("a_1.exr")), third = covered(image("a_3.exr"));
  EXPECT_GT(third, 48u * 48 / 2);
  EXPECT_LT(first, third / 4);
  EXPECT_GT(first, 0u);
  EXPECT_EQ(readImageText(in("a_2.exr")).at("kiln:series"), "1-3");
}

TEST_F(SeriesCli, Frame_isTheSameWhicheverOthersAreDrawn) {
  for (const int frame : {1, 2, 3}) convert(frame);
  done(drawing("1-3", "all_#.exr"));
  done(drawing("2", "one.exr"));
  EXPECT_TRUE(image("one.exr").rgba == image("all_2.exr").rgba);
  std::vector<std::string> repeated = drawing("2", "repeated.exr");
  repeated.insert(repeated.end(), {"--repeat", "2"});
  done(repeated);
  EXPECT_TRUE(image("repeated.exr").rgba == image("all_2.exr").rgba);
  if (!canRunRanks()) GTEST_SKIP() << "this build has no MPI, or there is no mpirun: not compared with ranks";
  ToolOptions ranks;
  ranks.ranks = 2;
  done(drawing("1-3", "ranks_#.exr"), ranks);
  for (const char* number : {"1", "2", "3"})
    EXPECT_TRUE(image(std::string("ranks_") + number + ".exr").rgba ==
                image(std::string("all_") + number + ".exr").rgba);
}

// A frame written after the first pictures must not change the earlier pictures. Known: the camera is fitted to the
// readable stores, and a damaged or unfinished store fails as its own frame.
TEST_F(SeriesCli, FrameWithoutReadableManifest_costsNoOther) {
  for (const int frame : {1, 2, 3}) convert(frame);
  const fs::path manifest = in("s_002.kiln/manifest.json");
  writeText(manifest, "x");
  const ToolResult damaged = runTool(drawing("1-3", "a_#.exr"));
  EXPECT_EQ(damaged.exit_code, 1);
  EXPECT_NE(damaged.err.find("of frames 1,3"), std::string::npos) << damaged.err;
  EXPECT_TRUE(fs::exists(in("a_1.exr")));
  EXPECT_FALSE(fs::exists(in("a_2.exr")));
  EXPECT_TRUE(fs::exists(in("a_3.exr")));
  fs::remove(manifest);
  EXPECT_NE(done(drawing("3-3", "b_#.exr")).err.find("of frames 1,3"), std::string::npos);
  EXPECT_TRUE(readFile(in("a_3.exr")) == readFile(in("b_3.exr")));
}

// Known: one process draws the other frames, too.
TEST_F(SeriesCli, UnreadableFrame_costsNoOtherOfRanks) {
  if (!canRunRanks()) GTEST_SKIP() << "this build has no MPI, or there is no mpirun: not drawn by ranks";
  ToolOptions ranks;
  ranks.ranks = 2;
  const auto drawsOnly = [&](int frame, const std::string& volume, const std::string& name) {
    SCOPED_TRACE(volume);
    for (const bool resumed : {false, true}) {
      std::vector<std::string> words = drawing("1-3", name, volume);
      if (resumed) words.emplace_back("--resume");
      const ToolResult result = runTool(words, ranks);
      EXPECT_EQ(result.exit_code, 1) << result.err;
      EXPECT_NE(result.err.find(frame == 3 ? "2 frames (1-2) failed" : "2 frames (2-3) failed"), std::string::npos)
          << result.err;
      EXPECT_TRUE(fs::remove(in(pathOfFrame(name, frame).string()))) << result.err;
    }
  };
  convert(3);
  convert(2);
  writeText(in("s_002.kiln/manifest.json"), "x");
  drawsOnly(3, "s_###.kiln", "a_#.exr");
  fs::resize_file(in("s_002.nrrd"), 300);
  fs::remove(in("s_003.nrrd"));
  writeFrame(1);
  drawsOnly(1, "s_###.nrrd", "b_#.exr");
}

TEST_F(SeriesCli, Resumed_looksAsItBegan) {
  for (const int frame : {1, 2}) convert(frame);
  done(drawing("1-2", "a_#.exr"));
  convert(4);
  std::vector<std::string> resumed = drawing("1-2,4", "a_#.exr");
  resumed.push_back("--resume");
  const ToolResult result = done(resumed);
  EXPECT_NE(result.out.find("1 drawn, 2 kept"), std::string::npos) << result.out;
  EXPECT_NE(result.err.find("of frames 1-2"), std::string::npos) << result.err;
  // A new run is framed by all frames.
  EXPECT_NE(done(drawing("4", "b_#.exr")).err.find("of frames 1-2,4"), std::string::npos);
  EXPECT_FALSE(image("b_4.exr").rgba == image("a_4.exr").rgba);
}

// The volume decides how all frames look, because it is in all of them.
TEST_F(SeriesCli, MasksAlone_areAtNoFrame) {
  convert(2);
  for (const int frame : {1, 2}) {
    writeFrame(frame);
    done({"convert", in(fmt::format("s_{:03}.nrrd", frame)), in(fmt::format("m_{}.kiln", frame)), "--labels"});
  }
  std::vector<std::string> masked = drawing("1-2", "a_#.exr", "s_002.kiln", "solid:20");
  masked.insert(masked.end(), {"--mask", in("m_#.kiln") + ":40,80"});
  const ToolResult result = done(masked);
  EXPECT_NE(result.err.find("for all frames: by the volume, which all frames share"), std::string::npos) << result.err;
  EXPECT_FALSE(readImageText(in("a_1.exr")).contains("kiln:series"));
  EXPECT_LT(covered(image("a_1.exr")), covered(image("a_2.exr")));
  masked.push_back("--resume");
  EXPECT_NE(done(masked).out.find("0 drawn, 2 kept"), std::string::npos);
}

TEST_F(SeriesCli, DigitsBehindTheNumber_areNoPartOfIt) {
  for (const char* name : {"v15.kiln", "v105.kiln", "v5.kiln", "v16.kiln"}) fs::create_directory(in(name));
  EXPECT_EQ(framesOnDisk(in("v#5.kiln")), (std::vector<int>{1, 10}));
  EXPECT_EQ(framesOnDisk(in("v##.kiln")), (std::vector<int>{15, 16, 105}));
}

TEST_F(SeriesCli, ForeignFiles_lookAsTheFirstOnTheDisk) {
  for (const int frame : {1, 2}) writeFrame(frame);
  const ToolResult later = done(drawing("2", "a_#.exr", "s_###.nrrd"));
  EXPECT_NE(later.err.find("by the box and values of frame 1"), std::string::npos) << later.err;
  done(drawing("1-2", "b_#.exr", "s_###.nrrd"));
  EXPECT_TRUE(image("a_2.exr").rgba == image("b_2.exr").rgba);
}

}  // namespace
}  // namespace kiln::test
