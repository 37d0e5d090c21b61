// Deep pictures, stereo pictures and panoramas as users see them: the files, their contents for other programs, and
// each wrong combination refused in one line before drawing.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStandardAttributes.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "base/file/file.h"
#include "image/compare.h"
#include "image/file/image_file.h"
#include "support/files/vdb_files.h"
#include "support/reference/drawing.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class ViewsCli : public ToolTest {
 protected:
  ViewsCli() : ToolTest("views_") {}
  void SetUp() override { done({"convert", "phantom:head:40x40x40", in("h.kiln"), "--brick-size", "16"}); }

  // `kiln render h.kiln -o NAME --size … OPTIONS`.
  ToolResult drawn(const std::string& name, std::vector<std::string> options) const {
    options.insert(options.begin(), {"render", in("h.kiln"), "-o", in(name)});
    if (std::find(options.begin(), options.end(), "--size") == options.end())
      options.insert(options.end(), {"--size", "60x40"});
    return done(options);
  }
  void refused(std::vector<std::string> arguments, const std::string& mention, int exit_code = 2) const {
    arguments.insert(arguments.begin(), {"render", in("h.kiln")});
    ToolTest::refused(arguments, exit_code, mention);
  }
  bool there(const std::string& name) const { return fs::exists(directory_ / name); }
};

// A pair.
const std::vector<std::string> kPair = {"--stereo", "both", "--interocular", "20", "--exr-type", "float"};

// --- deep

TEST_F(ViewsCli, ADeepPictureIsTheFlatOneToOiiotool) {
  if (std::system("oiiotool --help >/dev/null 2>&1") != 0) GTEST_SKIP() << "openimageio-tools is not there";
  for (const std::string& projection : {std::string("perspective"), std::string("orthographic")}) {
    writeText(in("job.json"), R"({"kiln": 1, "volume": "h.kiln", "image": {"width": 60, "height": 40},
      "outputs": [{"path": "deep.exr", "content": "deep"}, {"path": "flat.exr"}],
      "exr": {"type": "half", "deepSamples": 7, "deepError": 0.001},
      "transferFunction": "ct-bone-and-skin", "camera": {"projection": ")" +
                                  projection + R"("}})");
    done({"render", in("job.json")});
    const std::string command = "oiiotool " + in("deep.exr") + " --flatten -o " + in("flattened.exr");
    ASSERT_EQ(std::system(command.c_str()), 0);
    const ImageDifference d = compareImages(readImage(in("flattened.exr")), readImage(in("flat.exr")));
    EXPECT_GT(d.foreground, 300u);
    EXPECT_LE(d.largest, 0x1p-10) << projection;  // both are rounded to half floats, of values up to two
    EXPECT_NE(done({"compare", in("deep.exr"), in("flat.exr")}).out.find("PSNR"), std::string::npos);
  }
  // Two deep images, one behind the other, and a merge without loss.
  drawn("far.exr", {"--deep", "--region", "0,20,0,40,40,40", "--view", "front", "--fit", "box"});
  drawn("near.exr", {"--deep", "--region", "0,0,0,40,19,40", "--view", "front", "--fit", "box"});
  ASSERT_EQ(
      std::system(
          ("oiiotool " + in("far.exr") + " " + in("near.exr") + " --deepmerge --flatten -o " + in("both.exr")).c_str()),
      0);
  const Image far = readImage(in("far.exr")), near = readImage(in("near.exr")), both = readImage(in("both.exr"));
  for (std::size_t i = 0; i < both.rgba.size(); ++i) {
    const float over = near.rgba[i] + (1 - near.rgba[i | 3]) * far.rgba[i];
    ASSERT_NEAR(both.rgba[i], over, 2e-3f) << i;
  }
}

TEST_F(ViewsCli, ADeepPictureSaysHowItDiffersFromAFlatOne) {
  const std::string note = "a deep picture has one ray a pixel and no pixel filter";
  EXPECT_NE(drawn("deep.exr", {"--deep"}).err.find(in("deep.exr") + ": " + note), std::string::npos);
  EXPECT_NE(drawn("deep.exr", {"--deep", "--samples", "1"}).err.find(note), std::string::npos);
  EXPECT_EQ(drawn("flat.exr", {"--samples", "1"}).err.find(note), std::string::npos);
  // Beside a flat picture of equal rays there is no note.
  writeText(in("job.json"), R"({"kiln": 1, "volume": "h.kiln", "image": {"width": 60, "height": 40},
    "outputs": [{"path": "deep.exr", "content": "deep"}, {"path": "flat.exr"}]})");
  EXPECT_EQ(done({"render", in("job.json")}).err.find(note), std::string::npos);
}

TEST_F(ViewsCli, PngOfBrightFog_isNotedWithoutABackground) {
  writeVdb(in("fog.vdb"), {{.kind = VdbKind::kInt32}});
  const auto notes = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"render", in("fog.vdb"), "--size", "24x24"});
    return done(options).err.find("the fog is bright and the background transparent") != std::string::npos;
  };
  EXPECT_TRUE(notes({"-o", in("fog.png")}));
  EXPECT_TRUE(notes({"-o", in("fog.png"), "--tf", "fog"}));
  EXPECT_FALSE(notes({"-o", in("fog.exr")}));
  EXPECT_FALSE(notes({"-o", in("fog.png"), "--tf", "viridis"}));
  EXPECT_FALSE(notes({"-o", in("fog.png"), "--mode", "mip"}));
  for (const char* background : {"black", "transparent"})
    EXPECT_FALSE(notes({"-o", in("fog.png"), "--background", background})) << background;
}

TEST_F(ViewsCli, ADeepPictureIsOneOfAFramesFilesAndIsKeptByResume) {
  writeText(in("job.json"),
            R"({"kiln": 1, "volume": "h.kiln", "output": "f_##.exr", "image": {"width": 30, "height": 24},
    "outputs": [{"path": "deep_##.exr", "content": "deep"}], "exr": {"deepSamples": 9, "deepError": 0.002},
    "camera": {"turntable": {"frames": 2}}})");
  done({"render", in("job.json")});
  for (const std::string& number : {std::string("01"), std::string("02")})
    EXPECT_LT(compareImages(readImage(in("deep_" + number + ".exr")), readImage(in("f_" + number + ".exr"))).largest,
              1e-3);
  const auto before = fs::last_write_time(in("deep_02.exr"));
  fs::remove(in("deep_01.exr"));
  done({"render", in("job.json"), "--resume"});
  EXPECT_TRUE(there("deep_01.exr"));
  EXPECT_EQ(fs::last_write_time(in("deep_02.exr")), before);
  // Other bounds make a different file.
  const ToolResult other = runTool({"render", in("job.json"), "--resume", "--deep-samples", "8"});
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_NE(other.err.find("deep_01.exr: is a picture of another job"), std::string::npos) << other.err;
}

TEST_F(ViewsCli, SeveralVolumesAreDeepAndSeenByBothEyesAndAllRound) {
  done({"convert", "phantom:head:24x24x24", in("small.kiln"), "--brick-size", "16"});
  const std::vector<std::string> more = {"--add", in("small.kiln"), "--tf", "ct-bone-and-skin"};
  writeText(in("both.json"), R"({"kiln": 1, "image": {"width": 60, "height": 40},
    "volumes": [{"volume": "h.kiln", "transferFunction": "ct-bone-and-skin"}, {"volume": "small.kiln"}],
    "outputs": [{"path": "deep.exr", "content": "deep"}, {"path": "flat.exr"}]})");
  const auto with = [&](const std::vector<std::string>& options) {
    std::vector<std::string> out = more;
    out.insert(out.end(), options.begin(), options.end());
    return out;
  };
  done({"render", in("both.json")});
  const ImageDifference d = compareImages(readImage(in("deep.exr")), readImage(in("flat.exr")));
  EXPECT_GT(d.foreground, 300u);
  EXPECT_LE(d.largest, 0x1p-10);
  drawn("pair.exr", with(kPair));
  drawn("round.exr", with({"--projection", "equirectangular", "--size", "32x16", "--memory", "200M"}));
}

TEST_F(ViewsCli, WhatIsNotDeepIsRefused) {
  const std::string deep = in("d.exr");
  refused({"-o", in("d.png"), "--deep"}, "d.png: the name of a deep image ends in .exr");
  refused({"-o", deep, "--deep", "--mode", "mip"}, "d.exr: deep images need --mode composite (found --mode mip)");
  refused({"-o", deep, "--deep", "--lattice", "voxel"},
          "d.exr: deep images need --lattice pixel, or several volumes (found --lattice voxel)");
  refused({"-o", deep, "--deep", "--samples", "4"}, "--samples of a deep image is 1");
  refused({"-o", deep, "--deep", "--compression", "dwaa"}, "--compression of a deep image is none, rle or zips");
  refused({"-o", deep, "--deep", "--aov", "depth"}, "--aov of a deep image is none");
  refused({"-o", deep, "--deep", "--deep-samples", "0"}, "--deep-samples");
  refused({"-o", deep, "--deep", "--deep-error", "2"}, "--deep-error: expected a number from 0 to 1");
  refused({"-o", deep, "--deep", "--checkpoint"}, "--checkpoint: tiles of a deep image are not kept");
  refused({"-o", deep, "--deep-samples", "8"}, "no deep image is drawn; add --deep");
  refused({"-o", deep, "--deep", "--size", "1024x1024", "--memory", "300M"}, "of deep samples", 1);
  EXPECT_FALSE(there("d.exr"));
  const ToolResult cost = done({"render", in("h.kiln"), "--deep", "-o", deep, "--dry-run", "--deep-samples", "4"});
  EXPECT_NE(cost.out.find("of deep samples"), std::string::npos) << cost.out;
}

// --- both eyes

TEST_F(ViewsCli, BothEyesAreTwoPartsOfAnExr) {
  std::vector<std::string> pair = kPair;
  pair.insert(pair.end(), {"--aov", "depth,normal", "--crop", "10,5,40,30"});
  drawn("pair.exr", pair);
  pair[1] = "left", drawn("left.exr", pair);
  pair[1] = "right", drawn("right.exr", pair);
  Imf::MultiPartInputFile file(in("pair.exr").c_str());
  ASSERT_EQ(file.parts(), 2);
  for (int i = 0; i < 2; ++i) {
    const std::string eye = i == 0 ? "left" : "right";
    const Imf::Header& header = file.header(i);
    EXPECT_EQ(header.view(), eye);
    EXPECT_EQ(header.name(), eye);
    std::string names;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) names += std::string(c.name()) + " ";
    EXPECT_EQ(names, "A B G N.X N.Y N.Z R Z depth.mean ");
    // Each part stores its own camera.
    Imf::MultiPartInputFile single(in(eye + ".exr").c_str());
    EXPECT_EQ(Imf::worldToCamera(header), Imf::worldToCamera(single.header(0)));
    EXPECT_EQ(Imf::worldToNDC(header), Imf::worldToNDC(single.header(0)));
    // Each part has its own pixels.
    const Imath::Box2i window = header.dataWindow();
    EXPECT_EQ(window.min, Imath::V2i(10, 5));
    const Image alone = readImage(in(eye + ".exr"));
    std::vector<float> red(40 * 30);
    Imf::FrameBuffer buffer;
    buffer.insert("R", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(red.data() - 10 - 5 * 40), 4, 160));
    Imf::InputPart part(file, i);
    part.setFrameBuffer(buffer);
    part.readPixels(window.min.y, window.max.y);
    for (std::size_t p = 0; p < red.size(); ++p) ASSERT_EQ(red[p], alone.rgba[4 * p]) << eye;
  }
  EXPECT_FALSE(equalBits(readImage(in("left.exr")), readImage(in("right.exr"))));
  // A reader without support for parts gets the left eye's picture.
  EXPECT_TRUE(equalBits(readImage(in("pair.exr")), readImage(in("left.exr"))));
}

TEST_F(ViewsCli, BothEyesAreFilesWhereTheNameHasAPlaceForThemElseAPngIsWide) {
  drawn("e_%V.exr", kPair);
  drawn("e.png", kPair);
  drawn("%v_e.png", kPair);
  std::vector<std::string> one = kPair;
  one[1] = "right";
  drawn("alone_%V.exr", one);
  EXPECT_FALSE(there("alone_left.exr"));
  EXPECT_TRUE(equalBits(readImage(in("alone_right.exr")), readImage(in("e_right.exr"))));
  EXPECT_EQ(readImageText(in("alone_right.exr")), readImageText(in("e_right.exr")));
  const Image wide = readImage(in("e.png")), left = readImage(in("l_e.png")), right = readImage(in("r_e.png"));
  ASSERT_EQ(wide.width, 120);
  EXPECT_TRUE(equalBits(partOf(wide, {0, 0, 60, 40}), left));
  EXPECT_TRUE(equalBits(partOf(wide, {60, 0, 120, 40}), right));
  EXPECT_FALSE(equalBits(left, right));
  writeText(in("deep.json"), R"({"kiln": 1, "volume": "h.kiln", "image": {"width": 60, "height": 40},
    "stereo": {"eye": "both", "interocular": 20},
    "outputs": [{"path": "deep_%V.exr", "content": "deep"}, {"path": "flat_%V.exr"}]})");
  done({"render", in("deep.json")});
  EXPECT_LT(compareImages(readImage(in("deep_left.exr")), readImage(in("flat_left.exr"))).largest, 1e-3);
}

TEST_F(ViewsCli, PairsOfManyFramesAreResumed) {
  writeText(in("job.json"),
            R"({"kiln": 1, "volume": "h.kiln", "output": "p_##.exr", "image": {"width": 30, "height": 24},
    "outputs": [{"path": "%V/p_##.exr"}, {"path": "wide_##.png"}], "camera": {"turntable": {"frames": 2}},
    "stereo": {"eye": "both", "interocular": 20, "convergence": 300}})");
  fs::create_directories(in("left")), fs::create_directories(in("right"));
  done({"render", in("job.json")});
  const std::vector<std::byte> first = readFile(in("p_01.exr")), second = readFile(in("right/p_02.exr"));
  const auto kept = fs::last_write_time(in("p_02.exr"));
  fs::remove(in("right/p_01.exr"));
  writeText(in("p_01.exr"), std::string(reinterpret_cast<const char*>(first.data()), first.size() - 50));
  done({"render", in("job.json"), "--resume"});
  EXPECT_EQ(readFile(in("p_01.exr")), first);
  EXPECT_TRUE(there("right/p_01.exr"));
  EXPECT_EQ(readFile(in("right/p_02.exr")), second);
  EXPECT_EQ(fs::last_write_time(in("p_02.exr")), kept);
}

TEST_F(ViewsCli, PairsThatCannotBeAreRefused) {
  const std::string pair = in("p.exr");
  refused({"-o", pair, "--stereo", "both"}, "needs --interocular, the distance between both eyes; one thirtieth");
  refused({"-o", pair, "--stereo", "middle", "--interocular", "20"}, "--stereo");
  refused({"-o", pair, "--stereo", "both", "--interocular", "20", "--projection", "orthographic"},
          "--stereo: a pair is of a perspective camera");
  refused({"-o", pair, "--stereo", "both", "--interocular", "20", "--part", "1/2"}, "--part: --stereo");
  refused({"-o", pair, "--stereo", "both", "--interocular", "20", "--deep"}, "put %V");
}

// --- panoramas

TEST_F(ViewsCli, APanoramaIsOfAllRoundTheEye) {
  done({"render", in("h.kiln"), "-o", in("p.exr"), "--projection", "equirectangular", "--size", "96x48", "--aov",
        "depth"});
  const Image image = readImage(in("p.exr"), std::vector<std::string>{"Z"});
  EXPECT_EQ(image.width, 96);
  Imf::MultiPartInputFile file(in("p.exr").c_str());
  EXPECT_EQ(Imf::envmap(file.header(0)), Imf::ENVMAP_LATLONG);
  EXPECT_TRUE(Imf::hasWorldToCamera(file.header(0)));
  EXPECT_FALSE(Imf::hasWorldToNDC(file.header(0)));
  writeText(in("job.json"),
            R"({"kiln": 1, "volume": "h.kiln", "output": "r_##.exr", "image": {"width": 32, "height": 16},
    "camera": {"projection": "equirectangular", "eye": [0, 0, 0], "target": [1, 0, 0], "up": [0, 0, 1],
               "turntable": {"frames": 2}}})");
  done({"render", in("job.json")});
  const auto kept = fs::last_write_time(in("r_01.exr"));
  fs::remove(in("r_02.exr"));
  done({"render", in("job.json"), "--resume"});
  EXPECT_EQ(fs::last_write_time(in("r_01.exr")), kept);
  EXPECT_TRUE(there("r_02.exr"));
  EXPECT_NE(done({"render", in("job.json"), "--dry-run"}).out.find("of a face that it is made of"), std::string::npos);
}

TEST_F(ViewsCli, PanoramasThatCannotBeAreRefused) {
  const auto wrong = [&](std::vector<std::string> options, const std::string& mention) {
    options.insert(options.begin(), {"-o", in("p.exr"), "--projection", "equirectangular"});
    refused(options, mention);
  };
  wrong({"--size", "100x100"}, "twice as wide as high");
  wrong({"--fov", "60"}, "fov is not of an equirectangular camera");
  wrong({"--zoom", "2"}, "zoom is not of an equirectangular camera");
  wrong({"--height", "60"}, "height is not of an equirectangular camera");
  wrong({"--samples", "4"}, "--samples of a panorama is 1");
  wrong({"--part", "1/2"}, "--part of a panorama");
  wrong({"--deep"}, "--deep of a panorama");
  wrong({"--stereo", "left", "--interocular", "3"}, "--stereo of a panorama");
  wrong({"--checkpoint"}, "--checkpoint: tiles of a panorama are not kept");
  EXPECT_FALSE(there("p.exr"));
}

// The projection of camera keys is the job's: the same combinations are refused, and the picture is twice as wide.
TEST_F(ViewsCli, PanoramasOfCameraKeysThatCannotBeAreRefused) {
  writeText(in("job.json"), R"({"kiln": 2, "volume": "h.kiln", "output": "p.exr", "image": {"width": 32, "height": 16},
    "camera": {"keyframes": [{"frame": 1, "projection": "equirectangular"}]}})");
  const auto wrong = [&](std::vector<std::string> options, const std::string& mention) {
    options.insert(options.begin(), {"render", in("job.json")});
    ToolTest::refused(options, 2, mention);
  };
  wrong({"--samples", "4"}, "--samples of a panorama is 1");
  wrong({"--part", "1/2"}, "--part of a panorama");
  wrong({"--deep"}, "--deep of a panorama");
  wrong({"--scale-bar"}, "a panorama has no scale bar");
  wrong({"--aperture", "3"}, "only a perspective camera has a lens");
  wrong({"--checkpoint"}, "--checkpoint: tiles of a panorama are not kept");
  done({"render", in("job.json")});
  EXPECT_NE(done({"render", in("job.json"), "--dry-run"}).out.find("of a face that it is made of"), std::string::npos);
}

}  // namespace
}  // namespace kiln::test
