// Pictures as TIFF and JPEG, and on standard output. Known: standard output has the bytes of the file that the same
// command writes, and nothing else; all text is on standard error.
#include <gtest/gtest.h>

#include <filesystem>

#include "base/file/file.h"
#include "image/compare.h"
#include "image/file/image_file.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class PicturesCli : public ToolTest {
 protected:
  PicturesCli() : ToolTest("pictures_") {}
  void SetUp() override { done({"convert", "phantom:head:40x40x40", in("h.kiln"), "--brick-size", "16"}); }

  std::vector<std::string> render(const std::string& output, std::vector<std::string> options = {}) const {
    options.insert(options.begin(), {"render", in("h.kiln"), "-o", output, "--size", "60x40", "--background", "white"});
    return options;
  }
};

TEST_F(PicturesCli, StandardOutputHasTheBytesOfTheFile) {
  for (const auto& [output, file] : {std::pair{"-", "a.png"}, std::pair{"-.exr", "a.exr"}, std::pair{"-.tif", "a.tif"},
                                     std::pair{"-.jpg", "a.jpg"}, std::pair{"-.png", "a.png"}}) {
    done(render(in(file)));
    const ToolResult result = done(render(output, {"--verbose"}));
    EXPECT_EQ(result.out, readTextFile(in(file))) << output;
    EXPECT_FALSE(result.err.empty());
  }
  EXPECT_FALSE(fs::exists(directory_ / "-"));
}

TEST_F(PicturesCli, StandardOutputTakesOneWholePicture) {
  refused(render("-", {"--turntable", "4"}), 2, "takes one picture (found 4 frames)");
  refused(render("-", {"--resume"}), 2, "keeps nothing to go on from");
  EXPECT_TRUE(done(render("-", {"--turntable", "4", "--sheet", "2"})).out.starts_with("\x89PNG"));
  EXPECT_TRUE(done(render("-", {"--dry-run"})).out.empty());
  for (const char* const option : {"--stats", "--trace"})
    refused(render(in("a.png"), {option, "-"}), 2, option + std::string(": standard output takes a picture alone"));
}

TEST_F(PicturesCli, TiffAndJpegShowThePicture) {
  done(render(in("a.png"), {"--png-bits", "16"}));
  for (const auto& [name, least] : {std::pair{"a.tif", 90.0}, std::pair{"a.jpg", 30.0}}) {
    done(render(in(name)));
    const ImageDifference difference = compareImages(readImage(in("a.png")), readImage(in(name)));
    EXPECT_GT(difference.psnr_db, least) << name;
  }
}

// A composite is transparent beside the head; over a background it is not.
TEST_F(PicturesCli, BlackOfATransparentJpegIsNoted) {
  for (const std::string background : {"transparent", "white"}) {
    for (const std::string part : {"1", "2"})
      done({"render", in("h.kiln"), "-o", in(part + ".exr"), "--size", "40x40", "--part", part + "/2", "--background",
            background});
    const ToolResult jpeg = done({"composite", in("1.exr"), in("2.exr"), "-o", in("c.jpg")});
    EXPECT_EQ(jpeg.err.find("a JPEG has no transparency") != std::string::npos, background == "transparent");
    EXPECT_EQ(done({"composite", in("1.exr"), in("2.exr"), "-o", in("c.png")}).err.find("transparency"),
              std::string::npos);
  }
}

TEST_F(PicturesCli, ResumeKeepsTiffAndJpeg) {
  for (const std::string name : {"a.tif", "a.jpg"}) {
    done(render(in(name)));
    const auto time = fs::last_write_time(in(name));
    done(render(in(name), {"--resume"}));
    EXPECT_EQ(fs::last_write_time(in(name)), time);
    refused(render(in(name), {"--resume", "--axes"}), 1, "is a picture of another job: annotations");
    // A file that a killed copy has left short is drawn again.
    fs::resize_file(in(name), fs::file_size(in(name)) - 40);
    done(render(in(name), {"--resume"}));
    checkImage(in(name));
  }
  refused(render(in("a.jpg"), {"--resume", "--jpeg-quality", "50"}), 1, "is a picture of another job");
}

TEST_F(PicturesCli, AJpegNeedsABackground) {
  refused({"render", in("h.kiln"), "-o", in("a.jpg"), "--size", "8x8"}, 2, "a JPEG has no transparency");
  done({"render", in("h.kiln"), "-o", in("a.jpg"), "--size", "8x8", "--mode", "mip"});
  refused({"render", in("h.kiln"), "-o", in("a.tif"), "--size", "8x8", "--aov", "depth"}, 2, "only an EXR holds more");
}

// libjpeg encodes sides of at most 65500 pixels. A picture beyond is refused before the first frame is drawn, with exit
// code 2; a frame that fails gives exit code 1.
TEST_F(PicturesCli, ATooLargeJpegIsRefusedBeforeItIsDrawn) {
  const std::vector<std::string> head = {"render", in("h.kiln"), "--background", "white", "--samples", "1"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), head.begin(), head.end());
    return more;
  };
  const std::string why = "a JPEG has sides of at most 65500 pixels (found ";
  refused(with({"--turntable", "2", "-o", in("a#.jpg"), "--size", "65536x1"}), 2, why + "65536 x 1)");
  refused(with({"--turntable", "2", "--stereo", "both", "--interocular", "1", "-o", in("a#.jpg"), "--size", "40000x1"}),
          2, why + "80000 x 1)");
  refused(with({"--turntable", "2", "--sheet", "2", "-o", in("a.jpg"), "--size", "65520x1"}), 2, why + "65536 x ");
  done(with({"-o", in("a.jpg"), "--size", "65536x1", "--crop", "0,0,65500,1"}));
  done(with({"--stereo", "both", "--interocular", "1", "-o", in("a_%V.jpg"), "--size", "65500x1"}));
}

}  // namespace
}  // namespace kiln::test
