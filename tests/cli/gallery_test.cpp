// The sheet of thumbnails. Known: each thumbnail is the picture that the options beside it draw, over the sheet's
// paper.
#include "sequence/sheet/gallery.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "image/display.h"
#include "image/file/image_file.h"
#include "image/srgb.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {

class GalleryCli : public ToolTest {
 protected:
  GalleryCli() : ToolTest("gallery_") {}
  void SetUp() override { done({"convert", "phantom:head:40x40x40", in("h.kiln"), "--brick-size", "16"}); }
};

// The sheet's layout is found by its first thumbnail: 8 pixels from the left, below a title and a caption. A sheet
// shows light as a PNG does.
TEST_F(GalleryCli, Thumbnails_areThePicturesOfTheirOptions) {
  constexpr int kEdge = 48, kLeft = 8, kTop = 24 + 16, kColumn = kEdge + 8, kRow = 16 + kEdge + 8;
  const std::string sides[] = {"front", "left", "top"};
  const auto check = [&](const std::vector<std::string>& presets, const std::string& look, const Display& display) {
    SCOPED_TRACE(look);
    std::vector<std::string> gallery = {"gallery",     in("h.kiln"), "-o",     in("sheet.exr"),
                                        "--thumbnail", "48",         "--look", look};
    for (const std::string& preset : presets) gallery.insert(gallery.end(), {"--tf", preset});
    done(gallery);
    const Image sheet = readImage(in("sheet.exr"));
    ASSERT_EQ(sheet.width, 4 * kColumn + 8);
    ASSERT_EQ(sheet.height, 24 + static_cast<int>(presets.size()) * kRow);
    const float* const corner = sheet.pixel(kLeft, kTop);
    const float paper[3] = {corner[0], corner[1], corner[2]};
    for (int row = 0; row < static_cast<int>(presets.size()); ++row) {
      for (int column = 0; column < 4; ++column) {
        std::vector<std::string> options = {
            "render", in("h.kiln"), "-o",        in("one.exr"), "--tf",       presets[static_cast<std::size_t>(row)],
            "--size", "48x48",      "--samples", "1",           "--exr-type", "float",
            "--look", look};
        if (column > 0) options.insert(options.end(), {"--view", sides[column - 1]});
        done(options);
        Image one = readImage(in("one.exr"));
        show(display, one);
        int shown = 0;
        for (int y = 0; y < kEdge; ++y) {
          for (int x = 0; x < kEdge; ++x) {
            const float* const pixel = one.pixel(x, y);
            shown += pixel[3] > 0.1f ? 1 : 0;
            for (int channel = 0; channel < 3; ++channel) {
              const float over = pixel[channel] + (1 - pixel[3]) * paper[channel];
              // The sheet is written in halves.
              ASSERT_NEAR(sheet.pixel(kLeft + column * kColumn + x, kTop + row * kRow + y)[channel], over, 1e-3)
                  << row << " " << column << " " << x << "," << y;
            }
          }
        }
        EXPECT_GT(shown, 200) << row << " " << column;
      }
    }
  };
  check({"ct-bone", "viridis"}, "plain", {});
  check({"ct-bone"}, "studio", {0, Tone::kSoft});
}

TEST_F(GalleryCli, AllPresets_haveACommandEach) {
  const ToolResult result = done({"gallery", in("h.kiln"), "-o", in("sheet.png"), "--thumbnail", "32"});
  EXPECT_NE(result.out.find("--tf auto -o auto.png\n"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("--tf ct-bone -o ct-bone.png\n"), std::string::npos) << result.out;
  EXPECT_EQ(result.out.find("levelset"), std::string::npos) << "a solid box of a volume that is no level set";
  EXPECT_NE(result.out.find("bricks read ("), std::string::npos) << result.out;
  const ToolResult studio = done(
      {"gallery", in("h.kiln"), "-o", in("sheet.png"), "--thumbnail", "32", "--tf", "ct-bone", "--look", "studio"});
  EXPECT_NE(studio.out.find("--tf ct-bone --look studio -o ct-bone.png\n"), std::string::npos) << studio.out;
}

// The printed command runs in a shell.
TEST_F(GalleryCli, TheStoresName_isOneWordOfTheCommand) {
  std::filesystem::rename(in("h.kiln"), in("it's a head.kiln"));
  const std::string out =
      done({"gallery", in("it's a head.kiln"), "-o", in("g.png"), "--tf", "fire", "--thumbnail", "32"}).out;
  const std::string command = out.substr(out.find("render "), out.find('\n') - out.find("render "));
  EXPECT_EQ(std::system(("cd '" + in("") + "' && '" + KILN_TOOL + "' " + command + " --size 8x8 > /dev/null").c_str()),
            0);
  EXPECT_TRUE(std::filesystem::exists(in("fire.png")));
}

TEST_F(GalleryCli, StoreWithATrailingSlash_hasItsNameInTheTitle) {
  done({"gallery", in("h.kiln"), "-o", in("plain.exr"), "--tf", "fire", "--thumbnail", "32"});
  done({"gallery", in("h.kiln/"), "-o", in("slash.exr"), "--tf", "fire", "--thumbnail", "32"});
  EXPECT_EQ(readImage(in("plain.exr")).rgba, readImage(in("slash.exr")).rgba);
}

TEST_F(GalleryCli, WrongRequests_areOneLine) {
  refused({"gallery", in("h.kiln"), "-o", in("sheet.png"), "--tf", "ct-bones"}, 2, "--tf: 'ct-bones' is no preset");
  refused({"gallery", in("h.kiln"), "-o", in("sheet.png"), "--tf", "iso:x"}, 2, "--tf: 'iso:x'");
  refused({"gallery", in("h.kiln"), "-o", in("sheet.png"), "--look", "grand"}, 2, "--look");
  refused({"gallery", in("h.kiln"), "-o", in("sheet.png"), "--look", "studoi"}, 2,
          "--look: expected one of plain, studio, found 'studoi'; did you mean 'studio'?\n");
  refused({"gallery", in("h.kiln"), "-o", in("sheet.png"), "--tf", "ct-bonne"}, 2, "did you mean 'ct-bone'?\n");
  refused({"gallery", in("h.kiln"), "-o", in("sheet.png"), "--memory", "1M"}, 1, "--memory");
  refused({"gallery", in("h.kiln"), "-o", in("h.kiln/sheet.png")}, 2, "h.kiln");
  refused({"gallery", in("none.kiln"), "-o", in("sheet.png")}, 1, "none.kiln");
}

}  // namespace
}  // namespace kiln::test
