// Looks, exposure and tone of a whole run. Known: an EXR is linear light and does not change; a PNG of 16 bits holds
// its light within 1e-4, so that the shown light follows from the light of the EXR; a background is a colour of the
// user's.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "base/file/file.h"
#include "image/display.h"
#include "image/file/image_file.h"
#include "job/render_job.h"
#include "support/system/run_tool.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class LookCli : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ = freshDirectory(std::string("look_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
    store_ = makeStore(head({{20, 20, 16}, VoxelType::i16, obliqueAffine()}, {-1000, 2000}),
                       directory_.filename().string() + "/store", 16)
                 .string();
  }
  std::string in(const std::string& name) const { return (directory_ / name).string(); }

  void run(const std::vector<std::string>& arguments) const {
    const ToolResult result = runTool(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  Image drawn(const std::string& name, std::vector<std::string> options) const {
    options.insert(options.begin(), {"render", store_, "-o", in(name), "--size", "24x20", "--tf", "fire"});
    if (name.ends_with(".png")) options.insert(options.end(), {"--png-bits", "16"});
    if (name.ends_with(".exr")) options.insert(options.end(), {"--exr-type", "float"});
    run(options);
    return readImage(in(name));
  }
  RenderJob jobIn(const std::string& name) const {
    return parseJob(readImageText(in(name)).at(ImageMetadata::kJob), "job.json");
  }

  fs::path directory_;
  std::string store_;
};

// Expects pictures whose straight colours and alphas differ by what 16 bits round.
void expectAsShown(const Image& found, const Image& expected) {
  ASSERT_EQ(found.rgba.size(), expected.rgba.size());
  for (std::size_t i = 0; i < found.rgba.size(); i += 4) {
    EXPECT_NEAR(found.rgba[i + 3], expected.rgba[i + 3], 1e-5);
    for (std::size_t c = i; c < i + 3; ++c)
      EXPECT_NEAR(found.rgba[c], std::min(expected.rgba[c], expected.rgba[i + 3]), 1e-4) << i / 4;
  }
}

// Nothing is farther away than the volume's other end, and no time is spent beyond it.
TEST_F(LookCli, OcclusionBeyondTheVolume_isThatOfTheWholeVolume) {
  const Image far = drawn("far.exr", {"--ambient-occlusion", "0.5:1000000000"});
  EXPECT_EQ(far.rgba, drawn("whole.exr", {"--ambient-occlusion", "0.5:100000"}).rgba);
  EXPECT_NE(far.rgba, drawn("near.exr", {"--ambient-occlusion", "0.5:2"}).rgba);
}

TEST_F(LookCli, Studio_standsForItsOptions_andOptionsBesideItWin) {
  drawn("studio.png", {"--look", "studio"});
  EXPECT_EQ(jobIn("studio.png").picture.shading, studioShading());
  EXPECT_EQ(jobIn("studio.png").picture.display, (Display{0, Tone::kSoft}));
  drawn("own.png", {"--tone", "clip", "--ambient", "0.1", "--light", "headlight", "--look", "studio"});
  Shading own = studioShading();
  own.ambient = 0.1;
  own.lights = {Light{}};
  EXPECT_EQ(jobIn("own.png").picture.shading, own);
  EXPECT_EQ(jobIn("own.png").picture.display, Display());
  run({"render", in("studio.png"), "-o", in("again.png"), "--png-bits", "16"});
  EXPECT_EQ(readTextFile(in("again.png")), readTextFile(in("studio.png")));
}

TEST_F(LookCli, Plain_changesNoByte) {
  for (const char* ending : {".png", ".exr"}) {
    drawn(std::string("a") + ending, {});
    drawn(std::string("b") + ending, {"--look", "plain", "--exposure", "0", "--tone", "clip"});
    EXPECT_EQ(readTextFile(in(std::string("b") + ending)), readTextFile(in(std::string("a") + ending)));
  }
}

TEST_F(LookCli, Exposure_changesThePngAlone) {
  const Image light = drawn("light.exr", {"--background", "0.2,0.3,0.4:transparent"});
  const Image foreground = drawn("foreground.exr", {});
  for (const double exposure : {1.0, -2.0}) {
    const std::vector<std::string> options = {"--exposure", std::to_string(exposure), "--background",
                                              "0.2,0.3,0.4:transparent"};
    EXPECT_EQ(drawn("exposed.exr", options).rgba, light.rgba);
    const Image shown = drawn("exposed.png", options);
    Image expected = foreground;
    for (int y = 0; y < expected.height; ++y) {
      const double t = y / 19.0;
      const double behind[] = {0.2 * (1 - t), 0.3 * (1 - t), 0.4 * (1 - t), 1 - t};
      for (int x = 0; x < expected.width; ++x) {
        float* const pixel = expected.pixel(x, y);
        const double open = 1 - pixel[3];
        for (int c = 0; c < 4; ++c)
          pixel[c] = static_cast<float>(pixel[c] * (c < 3 ? std::exp2(exposure) : 1) + open * behind[c]);
      }
    }
    expectAsShown(shown, expected);
  }
}

TEST_F(LookCli, SoftTone_changesThePngAlone) {
  const std::vector<std::string> bright = {"--ambient", "2", "--background", "white"};
  const Image light = drawn("light.exr", bright);
  std::vector<std::string> options = bright;
  options.insert(options.end(), {"--tone", "soft"});
  EXPECT_EQ(drawn("soft.exr", options).rgba, light.rgba);
  Image expected = drawn("foreground.exr", {"--ambient", "2"});
  show({0, Tone::kSoft}, expected);
  for (std::size_t i = 0; i < expected.rgba.size(); i += 4) {
    const float open = 1 - expected.rgba[i + 3];
    for (std::size_t c = i; c < i + 4; ++c) expected.rgba[c] += open;
  }
  expectAsShown(drawn("soft.png", options), expected);
}

// A job writes both media from one frame.
TEST_F(LookCli, ExrBesidePng_holdsTheLight) {
  const Image png = drawn("a.png", {"--exposure", "1", "--tone", "soft", "--background", "navy"});
  const Image exr = drawn("a.exr", {"--background", "navy"});
  std::ofstream(in("both.json")) << R"({"kiln": 2, "volume": ")" << store_ << R"(", "output": "both.exr",
    "outputs": [{"path": "both.png"}], "exr": {"type": "float"}, "png": {"bits": 16},
    "image": {"width": 24, "height": 20, "background": "navy"}, "transferFunction": "fire",
    "display": {"exposure": 1, "tone": "soft"}})";
  run({"render", in("both.json")});
  EXPECT_EQ(readImage(in("both.exr")).rgba, exr.rgba);
  EXPECT_EQ(readImage(in("both.png")).rgba, png.rgba);
}

TEST_F(LookCli, Tiles_crops_andEyes_areShownAsTheWholePicture) {
  const std::vector<std::string> look = {"--look", "studio", "--exposure", "0.5", "--background", "navy:orange"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.end(), look.begin(), look.end());
    return more;
  };
  const Image whole = drawn("whole.png", look);
  EXPECT_EQ(drawn("tiles.png", with({"--checkpoint"})).rgba, whole.rgba);
  EXPECT_EQ(drawn("tiles.exr", with({"--checkpoint"})).rgba, drawn("whole.exr", look).rgba);
  const Image crop = drawn("crop.png", with({"--crop", "4,6,10,9"}));
  for (int y = 0; y < crop.height; ++y)
    for (int x = 0; x < crop.width; ++x)
      for (int c = 0; c < 4; ++c) EXPECT_EQ(crop.pixel(x, y)[c], whole.pixel(x + 4, y + 6)[c]);
  const Image left = drawn("left.png", with({"--stereo", "left", "--interocular", "3"}));
  const Image both = drawn("both.png", with({"--stereo", "both", "--interocular", "3"}));
  ASSERT_EQ(both.width, 2 * left.width);
  for (int y = 0; y < left.height; ++y)
    for (int x = 0; x < 4 * left.width; ++x) EXPECT_EQ(both.pixel(0, y)[x], left.pixel(0, y)[x]);
}

TEST_F(LookCli, CompositedParts_areShownAsTheWholePicture) {
  const std::vector<std::string> look = {"--exposure", "1", "--tone", "soft", "--background", "navy"};
  const Image whole = drawn("whole.png", look);
  for (const char* part : {"1/2", "2/2"}) {
    std::vector<std::string> options = look;
    options.insert(options.end(), {"--part", part});
    options.insert(options.begin(), {"render", store_, "-o", in(std::string("part") + part[0] + ".exr"), "--size",
                                     "24x20", "--tf", "fire"});
    run(options);
  }
  run({"composite", in("part1.exr"), in("part2.exr"), "-o", in("made.png"), "--png-bits", "16"});
  const Image made = readImage(in("made.png"));
  ASSERT_EQ(made.rgba.size(), whole.rgba.size());
  for (std::size_t i = 0; i < made.rgba.size(); ++i) EXPECT_NEAR(made.rgba[i], whole.rgba[i], 5e-3);
}

// Colours of values are a scale: white stays white.
TEST_F(LookCli, ProjectedValues_haveNoTone) {
  drawn("plain.png", {"--mode", "mip"});
  drawn("studio.png", {"--mode", "mip", "--look", "studio"});
  EXPECT_EQ(readImage(in("studio.png")).rgba, readImage(in("plain.png")).rgba);
}

}  // namespace
}  // namespace kiln::test
