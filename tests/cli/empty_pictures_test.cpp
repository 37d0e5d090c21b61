// Empty pictures, and labels drawn as amounts: the picture is written, with a warning. Known because each command hides
// a visible body.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/file/file.h"
#include "image/file/image_file.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

const std::vector<std::string> kThinSlab = {"--clip", "0,1,0,-0.3", "--clip", "0,-1,0,0.300001"};
constexpr const char* kHaze = R"({"points": [{"value": 0, "color": [1, 1, 1], "opacity": 0},
                                             {"value": 1000, "color": [1, 1, 1], "opacity": 0.002}]})";

class EmptyPicturesCli : public ToolTest {
 protected:
  EmptyPicturesCli() : ToolTest("empty_") {}
  void SetUp() override { done({"convert", "phantom:head:24x24x24", in("h.kiln")}); }

  std::vector<std::string> with(std::vector<std::string> more) const {
    more.insert(more.begin(), {"render", in("h.kiln"), "-o", in("x.exr")});
    if (std::find(more.begin(), more.end(), "--size") == more.end()) more.insert(more.end(), {"--size", "24x24"});
    return more;
  }
  void expectEmpty(const std::vector<std::string>& options, const std::string& why) const {
    expectWarning(options, "the picture is empty: ", why);
    expectDryWarning(options, why);
  }
  void expectWarning(const std::vector<std::string>& options, const std::string& what, const std::string& why) const {
    const ToolResult result = done(with(options));
    EXPECT_NE(result.err.find("warning: " + what), std::string::npos) << result.err;
    EXPECT_NE(result.err.find(why), std::string::npos) << why << " is not in: " << result.err;
    const std::vector<std::string> lines = result.errorLines();
    const auto warns = [](const std::string& line) { return line.find("warning") != std::string::npos; };
    EXPECT_EQ(std::count_if(lines.begin(), lines.end(), warns), 1) << result.err;
    EXPECT_TRUE(fs::exists(in("x.exr")));
    std::vector<std::string> strict = with(options);
    strict.push_back("--strict");
    const ToolResult failed = runTool(strict);
    EXPECT_EQ(failed.exit_code, 1) << failed.err;
    EXPECT_NE(failed.err.find("--strict: all is done, but there was a warning"), std::string::npos) << failed.err;
  }
  void expectDryWarning(const std::vector<std::string>& options, const std::string& why) const {
    std::vector<std::string> dry = with(options);
    dry.push_back("--dry-run");
    EXPECT_NE(done(dry).err.find(why), std::string::npos) << why;
  }
};

// All files of bricks are cut short: the transfer function and the camera have no part in the emptiness.
TEST_F(EmptyPicturesCli, MissingBricks_areTheReasonForAnEmptyPicture) {
  for (const fs::directory_entry& file : fs::recursive_directory_iterator(in("h.kiln/bricks")))
    if (file.is_regular_file()) fs::resize_file(file.path(), 50);
  for (const char* const mode : {"composite", "mip"}) {
    const std::string text = done(with({"--skip-damaged", "--mode", mode})).err;
    EXPECT_NE(text.find("the picture is empty: damaged bricks are missing, and the others show nothing"),
              std::string::npos)
        << text;
    EXPECT_EQ(text.find("the value of no voxel"), std::string::npos) << text;
  }
}

TEST_F(EmptyPicturesCli, Nothing_isSaidOfAPictureThatShowsSomething) {
  for (const std::vector<std::string>& options : {std::vector<std::string>{},
                                                  {"--lattice", "voxel"},
                                                  {"--mode", "mip"},
                                                  {"--mode", "average"},
                                                  {"--projection", "orthographic"},
                                                  {"--deep", "--samples", "1"},
                                                  {"--checkpoint"},
                                                  {"--part", "1/2"},
                                                  {"--add", in("h.kiln"), "--add-tf", "ct-bone"}}) {
    std::vector<std::string> command = with(options);
    command.push_back("--strict");
    EXPECT_EQ(done(command).err.find("warning"), std::string::npos) << (options.empty() ? "" : options.back());
  }
}

TEST_F(EmptyPicturesCli, EachReason_isNamed) {
  writeText(in("clear.json"), R"({"points": [{"value": 0, "color": [1, 1, 1], "opacity": 0}]})");
  writeText(in("beside.json"), R"({"points": [{"value": 30000, "color": [1, 1, 1], "opacity": 0},
                                              {"value": 30001, "color": [1, 1, 1], "opacity": 1}]})");
  expectEmpty({"--tf", in("clear.json")}, "opacity 0 everywhere");
  expectEmpty({"--tf", in("beside.json")}, "transparent for all values of the volume");
  expectEmpty({"--clip", "0,0,1,-100000"}, "leave nothing of the volume");
  expectEmpty({"--eye", "0,-1000,0", "--target", "0,-2000,0"}, "looks away from it");
  expectEmpty({"--eye", "0,-1000,0", "--target", "-1000,-1000,0", "--fov", "20"}, "looks past it");
  // Shadow maps show the volume where the picture does not.
  expectEmpty({"--eye", "0,-1000,0", "--target", "0,-2000,0", "--shadows", "--light", "cam:-1,1,1"},
              "looks away from it");
  expectEmpty({"--projection", "orthographic", "--eye", "5000,-1000,0", "--target", "5000,0,0", "--height", "10"},
              "looks past it");
  expectEmpty({"--clip", "0,0,1,-100000", "--background", "1,1,1"}, "leave nothing of the volume");
  expectEmpty({"--clip", "0,0,1,-100000", "--lattice", "voxel"}, "leave nothing of the volume");
  expectEmpty({"--clip", "0,0,1,-100000", "--mode", "mip"}, "leave nothing of the volume");
  expectEmpty({"--tf", in("clear.json"), "--add", in("h.kiln"), "--add-tf", in("clear.json")}, "opacity 0 everywhere");
  expectEmpty({"--tf", in("clear.json"), "--add", in("h.kiln"), "--add-tf", in("beside.json")},
              "clipped away, out of view, or the value of no voxel");
}

// Known because label 7 is in a corner of the mask alone, outside the body.
TEST_F(EmptyPicturesCli, MaskThatHidesAll_isAReason) {
  writeText(in("m.nrrd"),
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspace: left-posterior-superior\n"
            "space directions: (80,0,0) (0,80,0) (0,0,80)\nspace origin: (-120,-120,1600)\n"
            "space units: \"mm\" \"mm\" \"mm\"\nencoding: raw\n\n" +
                std::string(63, 3) + std::string(1, 7));
  done({"convert", in("m.nrrd"), in("m.kiln"), "--labels"});
  const std::string why = "is hidden by the mask, clipped away, out of view, or the value of no voxel";
  expectWarning({"--mask", in("m.kiln") + ":7"}, "the picture is empty: ", why);
  expectWarning({"--mask", in("m.kiln") + ":7", "--add", in("h.kiln"), "--add-tf", "solid:30000"},
                "the picture is empty: ", why);
  // A certain reason is the only one.
  expectEmpty({"--mask", in("m.kiln") + ":3", "--clip", "0,0,1,-100000"}, "leave nothing of the volume");
}

TEST_F(EmptyPicturesCli, VolumeFarSmallerThanAPixel_isNamedForEachProjection) {
  const std::string why = "far smaller than a pixel";
  expectEmpty({"--zoom", "1e-5"}, why);
  expectEmpty({"--zoom", "1e-5", "--add", in("h.kiln")}, why);
  expectEmpty({"--eye", "0,-1e9,0"}, why);
  expectEmpty({"--projection", "orthographic", "--height", "1e9", "--view", "front"}, why);
  expectEmpty({"--projection", "equirectangular", "--size", "48x24", "--eye", "0,-1e7,0"}, why);
}

// The whole body is a haze, and a slab of a millionth of a voxel contains almost nothing.
TEST_F(EmptyPicturesCli, ThinPart_isNamedForEachLatticeAndProjection) {
  writeText(in("haze.json"), kHaze);
  const std::vector<std::string> haze = {"--tf", in("haze.json")};
  const auto with_haze = [&](std::vector<std::string> options) {
    options.insert(options.end(), haze.begin(), haze.end());
    return options;
  };
  for (const std::vector<std::string>& options : {std::vector<std::string>{},
                                                  {"--projection", "orthographic", "--background", "1,1,1"},
                                                  {"--projection", "equirectangular", "--size", "48x24"},
                                                  {"--stereo", "both", "--interocular", "20"},
                                                  {"--checkpoint"},
                                                  {"--deep", "--samples", "1"},
                                                  {"--add", in("h.kiln"), "--add-tf", in("haze.json")}}) {
    std::vector<std::string> strict = with_haze(options);
    strict.push_back("--strict");
    EXPECT_EQ(done(with(strict)).err.find("warning"), std::string::npos) << (options.empty() ? "" : options.back());
    std::vector<std::string> thin = with_haze(options);
    thin.insert(thin.end(), kThinSlab.begin(), kThinSlab.end());
    expectWarning(thin, "the picture is empty: ", "too thin a part of the volume to be seen");
  }
  expectWarning(with_haze({"--world-region", "-200,-0.000001,1500,200,0.000001,1900"}),
                "the picture is empty: ", "too thin a part of the volume to be seen");
  // A partial image may be faint even if the whole picture is not.
  std::vector<std::string> part = with_haze({"--part", "1/2", "--strict"});
  part.insert(part.end(), kThinSlab.begin(), kThinSlab.end());
  EXPECT_EQ(done(with(part)).err, "");
}

// A slab a voxel thick is visible from the side.
TEST_F(EmptyPicturesCli, PartOfOneVoxel_isNotSaidToBeEmpty) {
  EXPECT_EQ(done(with({"--clip", "0,1,0,6", "--clip", "0,-1,0,6", "--strict"})).err, "");
}

TEST_F(EmptyPicturesCli, TransparentFunction_isNamed) {
  writeText(in("faint.json"), R"({"points": [{"value": -1000, "color": [1, 1, 1], "opacity": 0},
                                             {"value": 3000, "color": [1, 1, 1], "opacity": 1e-7}]})");
  expectWarning({"--tf", in("faint.json")}, "the picture is empty: ", "too transparent");
  expectWarning({"--tf", in("faint.json"), "--lattice", "voxel"}, "the picture is empty: ", "too transparent");
}

// The phantom has values from 0 to some 2500.
TEST_F(EmptyPicturesCli, FunctionOrWindowBesideTheValues_isNamed) {
  const auto expectOneColour = [&](const std::vector<std::string>& options) {
    const std::string why = "all values of a volume lie beside its transfer function or window";
    expectWarning(options, "the picture is of one colour: ", why);
    expectDryWarning(options, why);
  };
  writeText(in("above.json"), R"({"points": [{"value": 30000, "color": [1, 0, 0], "opacity": 0.5},
                                             {"value": 30001, "color": [0, 1, 0], "opacity": 1}]})");
  writeText(in("below.json"), R"({"points": [{"value": -30001, "color": [1, 0, 0], "opacity": 0},
                                             {"value": -30000, "color": [0, 1, 0], "opacity": 1}]})");
  writeText(in("constant.json"), R"({"points": [{"value": 30000, "color": [1, 0, 0], "opacity": 0.5}]})");
  expectOneColour({"--tf", in("above.json")});
  expectOneColour({"--tf", in("below.json")});
  expectOneColour({"--tf", "grayscale", "--window", "-50000,10"});
  expectOneColour({"--mode", "mip", "--window", "50000,10"});
  expectOneColour({"--add", in("h.kiln"), "--add-tf", in("below.json")});
  EXPECT_EQ(done(with({"--tf", in("constant.json"), "--strict"})).err, "");
  EXPECT_EQ(done(with({"--tf", "grayscale", "--window", "0,10", "--strict"})).err, "");
  for (const auto& [window, warns] : {std::pair{"50000,10", true}, {"0,100", false}}) {
    const ToolResult slice = done({"slice", in("h.kiln"), "-o", in("s.png"), "--window", window});
    EXPECT_EQ(slice.err.find("the picture is of one colour") != std::string::npos, warns) << slice.err;
  }
}

TEST_F(EmptyPicturesCli, VolumeOfOnePixel_isNotSaidToBeEmpty) {
  for (const char* projection : {"perspective", "orthographic"})
    EXPECT_EQ(done(with({"--zoom", "0.04", "--projection", projection, "--strict"})).err, "");
}

TEST_F(EmptyPicturesCli, WorldBoxBesideTheVolume_isRefusedAsRegionIs) {
  refused(with({"--region", "1000,1000,1000,1010,1010,1010"}), 2, "holds none of the volume's voxels");
  refused(with({"--world-region", "5000,5000,5000,5010,5010,5010"}), 2, "--world-region");
  refused(with({"--world-region", "5000,5000,5000,5010,5010,5010", "--add", in("h.kiln")}), 2, "--world-region");
  writeText(in("job.json"), R"({"kiln": 2, "volume": "h.kiln", "worldRegion": [5000, 5000, 5000, 5010, 5010, 5010]})");
  refused({"render", in("job.json"), "-o", in("x.exr")}, 2, "holds nothing of the volume, which is from ");
}

// Frames 2 and 3 of four look past the volume, and frame 4 away from it: a warning for each reason.
TEST_F(EmptyPicturesCli, Sequences_warnOnceWithTheFramesNumbers) {
  writeText(in("job.json"),
            R"({"kiln": 2, "volume": "h.kiln", "output": "f_#.png", "image": {"width": 16, "height": 16},
      "clip": {"keyframes": [{"frame": 1, "planes": [{"normal": [0, 0, 1], "offset": 10000}]},
                             {"frame": 2, "planes": [{"normal": [0, 0, 1], "offset": -10000}]},
                             {"frame": 4, "planes": [{"normal": [0, 0, 1], "offset": -10000}]}]}})");
  const ToolResult result = done({"render", in("job.json"), "--progress", "json"});
  EXPECT_NE(result.err.find("warning: 3 frames (2-4) are empty: the region"), std::string::npos) << result.err;
  EXPECT_EQ(result.errorLines().size(), 1u) << result.err;
  std::istringstream lines(result.out);
  int warnings = 0;
  for (std::string line; std::getline(lines, line);) {
    const Json event = Json::parse(line);
    if (event["event"] == "warning") {
      ++warnings;
      EXPECT_NE(event["warning"].get<std::string>().find("3 frames (2-4) are empty"), std::string::npos);
    }
    if (event["event"] == "frame_done") {
      EXPECT_EQ(event["empty"].is_null(), event["frame"] == 1) << line;
    }
  }
  EXPECT_EQ(warnings, 1);
}

TEST_F(EmptyPicturesCli, Ranks_warnAsOneProcessDoes) {
  if (!canRunRanks()) GTEST_SKIP() << "this build has no MPI, or there is no mpirun";
  std::vector<std::string> command = with({"--clip", "0,0,1,-100000"});
  ToolOptions two;
  two.ranks = 2;
  const ToolResult result = done(command, two);
  EXPECT_NE(result.err.find("warning: the picture is empty: the region"), std::string::npos) << result.err;
  command.push_back("--strict");
  EXPECT_EQ(runTool(command, two).exit_code, 1);
  writeText(in("haze.json"), kHaze);
  for (const char* const how : {"tiles", "bricks"}) {
    const ToolResult whole = done(with({"--distribute", how, "--strict"}), two);
    EXPECT_EQ(whole.err.find("warning"), std::string::npos) << how << ": " << whole.err;
    std::vector<std::string> slab = {"--tf", in("haze.json"), "--distribute", how};
    slab.insert(slab.end(), kThinSlab.begin(), kThinSlab.end());
    const ToolResult thin = done(with(slab), two);
    EXPECT_NE(thin.err.find("too thin a part"), std::string::npos) << how << ": " << thin.err;
  }
}

// Known because a label volume has a colour for each label, unlike amounts.
TEST_F(EmptyPicturesCli, LabelsBesideAVolume_areDrawnAsLabels) {
  std::string voxels(24 * 24 * 24, '\0');
  for (std::size_t i = 0; i < voxels.size(); ++i)
    voxels[i] = static_cast<char>(i / 24 % 24 < 8 ? 0 : i % 24 < 12 ? 1 : 7);
  writeText(
      in("l.nrrd"),
      "NRRD0005\ntype: uchar\ndimension: 3\nsizes: 24 24 24\nencoding: raw\nspace: LPS\nspace directions: (12,0,0) "
      "(0,12,0) (0,0,12)\nspace origin: (-138,-138,1600)\nspace units: \"mm\" \"mm\" \"mm\"\n\n" +
          voxels);
  done({"convert", in("l.nrrd"), in("labels.kiln"), "--labels"});
  done({"convert", in("l.nrrd"), in("amounts.kiln")});
  const auto drawn = [&](const std::vector<std::string>& options) {
    const ToolResult result = done(with(options));
    return std::pair(readImage(in("x.exr")).rgba, result.err);
  };
  const auto [right, nothing] = drawn({"--add", in("labels.kiln")});
  EXPECT_EQ(nothing, "");
  EXPECT_TRUE(drawn({"--labels", in("labels.kiln")}).first == right);
  const auto [converted, note] = drawn({"--labels", in("l.nrrd")});
  EXPECT_TRUE(converted == right);
  EXPECT_EQ(note.find("warning"), std::string::npos) << note;
  const auto [amounts, warning] = drawn({"--add", in("amounts.kiln")});
  EXPECT_FALSE(amounts == right);
  EXPECT_NE(warning.find("3 whole numbers, look like labels and are drawn as amounts; --labels FILE"),
            std::string::npos)
      << warning;
  // A named function draws amounts, without a warning.
  EXPECT_EQ(drawn({"--add", in("amounts.kiln"), "--add-tf", "grayscale"}).second, "");
  refused(with({"--labels", in("amounts.kiln")}), 2, "holds amounts; convert its source with kiln convert --labels");
  // An earlier store of amounts beside the file, made by a picture, is made anew.
  fs::remove_all(in("l.nrrd.kiln"));
  done(with({"--add", in("l.nrrd")}));
  EXPECT_TRUE(drawn({"--labels", in("l.nrrd")}).first == right);
  writeText(in("job.json"), R"({"kiln": 2, "volumes": [{"volume": "h.kiln"}, {"volume": "l.nrrd", "labels": true}],
                                "output": "x.exr", "image": {"width": 24, "height": 24}})");
  fs::remove_all(in("l.nrrd.kiln"));
  done({"render", in("job.json")});
  EXPECT_TRUE(readImage(in("x.exr")).rgba == right);
}

}  // namespace
}  // namespace kiln::test
