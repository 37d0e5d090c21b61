// Contents of a picture, as set on the command line. Known because the header of an EXR holds the job with every
// choice: drawn again, the file has equal bytes for every option. A wrong option gives one line that names the option.
#include <gtest/gtest.h>

#include <fstream>

#include "base/file/file.h"
#include "image/compare.h"
#include "image/file/image_file.h"
#include "image/file/png_file.h"
#include "support/system/run_tool.h"
#include "support/system/text_of.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class SceneCli : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ = freshDirectory(std::string("cli_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
    store_ = makeStore(head({{20, 20, 16}, VoxelType::i16, obliqueAffine()}, {-1000, 2000}),
                       directory_.filename().string() + "/store", 16)
                 .string();
  }
  std::string in(const std::string& name) const { return (directory_ / name).string(); }

  Image drawn(std::vector<std::string> options, const std::string& size = "24x20") const {
    options.insert(options.begin(), {"render", store_, "-o", in("a.exr"), "--size", size});
    const ToolResult result = runTool(options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return readImage(in("a.exr"));
  }
  // Draws the picture, draws it again from its header, and expects equality.
  Image drawnTwice(const std::vector<std::string>& options) const {
    const Image image = drawn(options);
    std::ofstream(in("job.json")) << readImageText(in("a.exr")).at("kiln:job");
    const ToolResult again = runTool({"render", in("job.json"), "-o", in("b.exr")});
    EXPECT_EQ(again.exit_code, 0) << again.err;
    EXPECT_EQ(readTextFile(in("a.exr")), readTextFile(in("b.exr"))) << options.front();
    return image;
  }
  void expectRefused(std::vector<std::string> options, const std::string& mentions) const {
    options.insert(options.begin(), {"render", store_, "-o", in("r.exr"), "--size", "8x8"});
    const ToolResult result = runTool(options);
    EXPECT_EQ(result.exit_code, 2) << mentions;
    EXPECT_EQ(result.errorLines().size(), 1u) << result.err;
    EXPECT_NE(result.err.find(mentions), std::string::npos) << result.err;
  }

  fs::path directory_;
  std::string store_;
};

TEST_F(SceneCli, TransferFunctionsOfEveryKind) {
  std::ofstream(in("maps.json")) << R"([{"Name": "A", "RGBPoints": [0, 0, 0, 0, 1, 1, 1, 1], "ColorSpace": "RGB"},
             {"Name": "B", "RGBPoints": [-500, 0, 0, 1, 900, 1, 0, 0], "Points": [-500, 0, 0.5, 0, 900, 1, 0.3, 0.6],
              "ColorSpace": "Lab"}])";
  const Image by_default = drawnTwice({"--tf", "auto"});
  for (const char* tf : {"iso:300", "viridis", "fire"}) EXPECT_NE(drawnTwice({"--tf", tf}).rgba, by_default.rgba) << tf;
  const Image whole = drawnTwice({"--tf", in("maps.json") + "#B"});
  EXPECT_NE(drawnTwice({"--tf", in("maps.json") + "#B", "--window", "700,300"}).rgba, whole.rgba);
  std::ofstream(in("windowed.json")) << R"({"kiln": 2, "volume": ")" + store_ +
                                            R"(", "transferFunction": "maps.json#B", "window": [700, 300],
                                              "image": {"width": 24, "height": 20}})";
  EXPECT_EQ(runTool({"render", in("windowed.json"), "-o", in("w.exr")}).exit_code, 0);
  EXPECT_EQ(readTextFile(in("a.exr")), readTextFile(in("w.exr")));
  expectRefused({"--tf", in("maps.json")}, "A, B");
  expectRefused({"--tf", "viridi"},
                "--tf: 'viridi' is neither a file nor points VALUE:OPACITY[:COLOR],... nor one of auto, ");
  expectRefused({"--tf", "ct-bonne"}, "iso:VALUE,... or solid:VALUE; did you mean 'ct-bone'?");
  expectRefused({"--tf", "quux"}, "iso:VALUE,... or solid:VALUE\n");
  expectRefused({"--tf", "iso:high"}, "--tf: 'iso:high': expected surfaces");
  expectRefused({"--tf", "solid:high"}, "--tf: 'solid:high': expected a number");
  expectRefused({"--window", "3"}, "--window: expected CENTRE,WIDTH");
  expectRefused({"--window", "3,0"}, "--window");
}

// A volume of 20 voxels in 24 pixels is refined, so that every interpolation gives a different picture.
TEST_F(SceneCli, Interpolation_inTheVoxelLattice_isRefused) {
  const Image linear = drawnTwice({"--tf", "fire"});
  EXPECT_EQ(drawn({"--tf", "fire", "--interpolation", "linear"}).rgba, linear.rgba);
  const Image cubic = drawnTwice({"--tf", "fire", "--interpolation", "cubic"});
  EXPECT_NE(cubic.rgba, linear.rgba);
  const Image catmull_rom = drawnTwice({"--tf", "fire", "--interpolation", "catmull-rom"});
  EXPECT_NE(catmull_rom.rgba, linear.rgba);
  EXPECT_NE(catmull_rom.rgba, cubic.rgba);
  expectRefused({"--interpolation", "cubical"}, "--interpolation: expected one of linear, cubic, catmull-rom");
  expectRefused({"--lattice", "voxel", "--interpolation", "cubic"},
                "--interpolation cubic: needs --lattice pixel, or several volumes (found --lattice voxel)");
}

TEST_F(SceneCli, DistancesOfSamples) {
  const Image by_default = drawnTwice({"--tf", "ct-bone"});
  EXPECT_EQ(drawn({"--tf", "ct-bone", "--sample-distance", "0.5"}).rgba, by_default.rgba);
  EXPECT_NE(drawnTwice({"--tf", "ct-bone", "--sample-distance", "0.9"}).rgba, by_default.rgba);
  for (const char* wrong : {"0.2", "1.1", "-1"})
    expectRefused({"--sample-distance", wrong}, "--sample-distance: expected a number of voxels from 0.25 to 1");
  for (const char* word : {"nan", "half"})
    expectRefused({"--sample-distance", word}, "--sample-distance: expected a number");
  expectRefused({"--lattice", "voxel", "--sample-distance", "0.6"},
                "--sample-distance: needs --lattice pixel, or several volumes (found --lattice voxel)");
  expectRefused({"--mode", "mip", "--sample-distance", "0.6"},
                "--sample-distance: needs --mode composite (found --mode mip)");
}

// Each option changes the picture, and its effect is in the header.
TEST_F(SceneCli, LightClippingAndBackground) {
  const Image by_default = drawnTwice({"--tf", "auto"});
  const std::vector<std::vector<std::string>> settings = {
      {"--shading", "none"},
      {"--ambient", "0.5", "--diffuse", "0.3", "--specular", "0.9", "--power", "2"},
      {"--light", "point:3,4,50:1,0.5,0", "--light", "headlight:0.2,0.2,0.2", "--light", "dir:1,-2,0.5", "--light",
       "cam:-1,1,0.5:0.3,0.3,0.6"},
      {"--region", "2,0,0,12,20,16"},
      {"--world-region", "0,-100,-100,12,100,100"},
      {"--clip", "1,0,0,-8", "--clip", "0,0,-1,9"},
      {"--background", "0.1,0.2,0.7:1,1,1"}};
  for (const std::vector<std::string>& these : settings) EXPECT_NE(drawnTwice(these).rgba, by_default.rgba) << these[0];
  EXPECT_EQ(
      drawn({"--light", "headlight", "--shading", "phong", "--background", "transparent", "--region", "0,0,0,20,20,16"})
          .rgba,
      by_default.rgba);
  // An option replaces the named cut of a job and keeps the other cuts.
  const auto of_job = [&](const std::string& box, const std::string& plane, const std::vector<std::string>& more) {
    writeText(in("cuts.json"), R"({"kiln": 2, "volume": ")" + store_ +
                                   R"(", "image": {"width": 32, "height": 24}, "worldRegion": )" + box +
                                   R"(, "clip": [)" + plane + "]}");
    std::vector<std::string> arguments = {"render", in("cuts.json"), "-o", in("cuts.exr")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ToolResult result = runTool(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return readImage(in("cuts.exr")).rgba;
  };
  const std::string box = "[0, -100, -100, 12, 100, 100]", wide = "[-100, -100, -100, 100, 100, 100]";
  const std::string plane = R"({"normal": [0, 0, -1], "offset": 9})", other = R"({"normal": [1, 0, 0], "offset": -5})";
  EXPECT_EQ(of_job(box, plane, {"--clip", "1,0,0,-5"}), of_job(box, other, {}));
  EXPECT_EQ(of_job(wide, plane, {"--world-region", "0,-100,-100,12,100,100"}), of_job(box, plane, {}));
  EXPECT_NE(of_job(box, plane, {}), of_job(wide, plane, {}));
  const std::vector<std::vector<std::string>> wrong = {{"--shading", "flat"},
                                                       {"--ambient", "-1"},
                                                       {"--power", "1e9"},
                                                       {"--light", "dir:0,0,0"},
                                                       {"--light", "point:1,2,3:1,1,-1"},
                                                       {"--region", "0,0,0,0.5,1,1"},
                                                       {"--world-region", "0,0,0,0,1,1"},
                                                       {"--clip", "0,0,0,1"},
                                                       {"--background", "0,0,2"},
                                                       {"--background", "0,0,0:1"}};
  for (const std::vector<std::string>& these : wrong) expectRefused(these, these[0] + ": expected ");
  expectRefused({"--region", "20,0,0,30,9,9"}, "the region from 20,0,0 to 30,9,9 (half-open) holds none");
}

TEST_F(SceneCli, ADryRun_printsTheWarningsOfTheRender) {
  const auto warnings = [&](std::vector<std::string> options, const std::string& input) {
    options.insert(options.begin(), {"render", input, "--shadows", "--scale-bar", "--scale-bar-length", "1000"});
    const ToolResult result = runTool(options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    std::vector<std::string> out = result.errorLines();
    std::erase_if(out, [](const std::string& line) { return line.find("warning") == std::string::npos; });
    return out;
  };
  const auto expectAlike = [&](const std::string& input, std::size_t count) {
    const std::vector<std::string> of_render =
        warnings({"-o", in("a_#.exr"), "--frames", "1", "--size", "24x20"}, input);
    EXPECT_EQ(of_render.size(), count);
    EXPECT_EQ(warnings({"--size", "24x20", "--frames", "1", "--dry-run"}, input), of_render);
  };
  expectAlike(store_, 2);
  // Lights of keyframes cast shadows, so that one warning is left.
  const std::string light = R"([{"type": "directional", "direction": [1, 0, 1]}])";
  std::ofstream(in("lit.json")) << R"({"kiln": 2, "volume": ")" << store_ << R"(", "lights": {"keyframes": [)"
                                << R"({"frame": 1, "lights": )" << light << R"(}, {"frame": 2, "lights": )" << light
                                << "}]}}";
  expectAlike(in("lit.json"), 1);
}

TEST_F(SceneCli, OpacityByGradientIsInTheFunction) {
  std::ofstream(in("plain.json")) << R"({"points": [{"value": 0, "color": [1, 1, 1], "opacity": 0.5}]})";
  std::ofstream(in("steep.json")) << R"({"points": [{"value": 0, "color": [1, 1, 1], "opacity": 0.5}],
      "gradientOpacity": [{"gradient": 10, "factor": 0}, {"gradient": 300, "factor": 1}]})";
  EXPECT_NE(drawnTwice({"--tf", in("plain.json")}).rgba, drawnTwice({"--tf", in("steep.json")}).rgba);
  EXPECT_NE(runTool({"tf", in("steep.json")}).out.find("of the opacity, by gradient"), std::string::npos);
}

// A picture that is white in its lower half shows gradients of the lower half only. Rows of numbers state the same.
TEST_F(SceneCli, OpacityOverValuesAndGradients_isInTheFunction) {
  Image halves(2, 8);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 2; ++x) {
      for (int c = 0; c < 4; ++c) halves.pixel(x, y)[c] = c == 3 || y >= 4 ? 1 : 0;
    }
  }
  const std::vector<std::byte> png = encodePng(halves, 8, in("halves.png"));
  writeText(in("halves.png"), textOf(png));
  const auto function = [&](const std::string& name, const std::string& plane) {
    std::ofstream(in(name)) << R"({"points": [{"value": 0, "color": [1, 1, 1], "opacity": 0.5}], )" << plane << "}";
    return drawnTwice({"--tf", in(name)}).rgba;
  };
  const std::string limits = R"("table": {"values": [-1000, 3000], "gradients": [0, 400], )";
  const auto of_picture = function("png.json", limits + R"("opacity": "halves.png"})");
  EXPECT_EQ(of_picture, function("rows.json", limits + R"("columns": 1, "opacity": [1, 1, 1, 1, 0, 0, 0, 0]})"));
  EXPECT_NE(of_picture, function("ones.json", limits + R"("columns": 1, "opacity": [1]})"));
  EXPECT_NE(runTool({"tf", in("png.json")}).out.find("2 x 8 factors of the opacity"), std::string::npos);
  EXPECT_NE(of_picture, function("region.json",
                                 R"("regions": [{"values": [-1000, 500], "gradients": [20, 400], "color": "red"}])"));
  EXPECT_NE(runTool({"tf", in("region.json")}).out.find("a rectangle, #ff0000"), std::string::npos);
}

// Known because the header of an EXR holds the resolved function, and all digits of its numbers are printed.
TEST_F(SceneCli, AFunctionAsJson_drawsTheSamePicture) {
  const auto expectSame = [&](const std::vector<std::string>& command, const std::string& tf) {
    const ToolResult json = runTool(command);
    EXPECT_EQ(json.exit_code, 0) << json.err;
    std::ofstream(in("my.json")) << json.out;
    drawn({"--tf", tf});
    const std::string expected = readTextFile(in("a.exr"));
    drawn({"--tf", in("my.json")});
    EXPECT_EQ(readTextFile(in("a.exr")), expected) << tf;
  };
  std::ofstream(in("steep.json"))
      << R"({"kiln": 2, "unit": 0.3, "points": [{"value": 0, "color": "teal", "opacity": 0.5}],
      "gradientOpacity": [{"gradient": 10, "factor": 0}, {"gradient": 300, "factor": 1}]})";
  std::ofstream(in("plane.json")) << R"({"kiln": 2, "points": [{"value": 0, "color": "teal", "opacity": 0.5}],
      "regions": [{"values": [-100, 900], "gradients": [10, 500], "color": "orange"}], "scattering": {"albedo": 0.9}})";
  // The store holds Hounsfield units. Its voxels have no length of 1.
  for (const std::string& tf : {std::string("ct-bone"), std::string("ct-xray"), std::string("300:0,500:0.5:#f80"),
                                in("steep.json"), in("plane.json")})
    expectSame({"tf", tf, "--json"}, tf);
  for (const char* tf : {"auto", "viridis", "mr-angio", "iso:300", "-300:0.01,500:0.5:navy"})
    expectSame({"tf", store_, "--tf", tf, "--json"}, tf);
}

TEST_F(SceneCli, ColoursByName_areThoseOfNumbers) {
  const auto sameAs = [&](const std::vector<std::string>& by_name, const std::vector<std::string>& by_number) {
    EXPECT_EQ(drawnTwice(by_name).rgba, drawnTwice(by_number).rgba) << by_name[1];
  };
  sameAs({"--background", "white:#000"}, {"--background", "1,1,1:0,0,0"});
  sameAs({"--light", "headlight:#f00", "--light", "dir:1,0,0:LIME"},
         {"--light", "headlight:1,0,0", "--light", "dir:1,0,0:0,1,0"});
  sameAs({"--tf", "0:0:#f00,900:0.5"}, {"--tf", "0:0,900:0.5:red"});
  expectRefused({"--background", "blak"}, "--background: expected COLOR");
  expectRefused({"--light", "headlight:oragne"}, "--light: expected headlight[:COLOR]");
  expectRefused({"--tf", "1:0,0:1"}, "--tf: expected points in order of their values, found 0 after 1");
  expectRefused({"--tf", "1:2"}, "--tf: expected points VALUE:OPACITY[:COLOR]");
  expectRefused({"--add", store_, "--add-tf", "1:2"}, "--add-tf: expected points VALUE:OPACITY[:COLOR]");
}

TEST_F(SceneCli, ATransferFunctionIsShown) {
  const ToolResult preset = runTool({"tf", "ct-bone"});
  EXPECT_EQ(preset.exit_code, 0) << preset.err;
  EXPECT_NE(preset.out.find("330   0.90000"), std::string::npos) << preset.out;
  EXPECT_NE(preset.out.find("#e7dec8"), std::string::npos) << preset.out;
  const ToolResult store = runTool({"tf", store_, "--tf", "grayscale", "--window", "100,50", "-o", in("tf.png")});
  EXPECT_EQ(store.exit_code, 0) << store.err;
  for (const char* says : {"75   0.00000", "3 points", "volume       values "})
    EXPECT_NE(store.out.find(says), std::string::npos) << store.out;
  const Image picture = readImage(in("tf.png"));
  EXPECT_EQ(picture.width, 960);
  // The red line of the opacity is at the bottom on the left, and nowhere else in its column.
  const auto red = [&](int x, int y) { return picture.pixel(x, y)[0] > 3 * picture.pixel(x, y)[1]; };
  EXPECT_TRUE(red(60, 329));
  for (int y = 30; y < 320; ++y) EXPECT_FALSE(red(60, y)) << y;
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"tf", "auto"},
                                                {"tf", "ct-bone", "--tf", "fog"},
                                                {"tf", "nothing"},
                                                {"tf", "fog", "-o", "x.bmp"}}) {
    const ToolResult refused = runTool(wrong);
    EXPECT_EQ(refused.exit_code, 2) << refused.err;
    EXPECT_EQ(refused.errorLines().size(), 1u) << refused.err;
  }
}

TEST_F(SceneCli, ACropIsThatPartOfThePicture) {
  const Image whole = drawn({});
  const Image part = drawnTwice({"--crop", "5,3,14,9"});
  ASSERT_EQ(part.width, 14);
  ASSERT_EQ(part.height, 9);
  for (int y = 0; y < part.height; ++y)
    EXPECT_TRUE(std::equal(part.pixel(0, y), part.pixel(0, y) + 4 * part.width, whole.pixel(5, 3 + y))) << y;
  for (const char* wrong : {"1,2,3", "0,0,4.5,4", "-1,0,4,4", "a,b,c,d"})
    expectRefused({"--crop", wrong}, "--crop: expected four whole numbers of pixels");
  for (const char* wrong : {"0,0,0,4", "4,0,5,4", "0,8,1,1"})
    expectRefused({"--crop", wrong}, "picture of 8 x 8 pixels");
}

TEST_F(SceneCli, SamplesOfAPixel) {
  const Image one = drawn({"--zoom", "0.5", "--samples", "1"});
  const Image four = drawnTwice({"--zoom", "0.5", "--samples", "4"});
  // By default, small voxels get more samples.
  EXPECT_EQ(drawn({"--zoom", "0.5"}).rgba, four.rgba);
  EXPECT_EQ(drawn({"--zoom", "0.5", "--samples", "auto"}).rgba, four.rgba);
  EXPECT_EQ(drawn({"--zoom", "8"}).rgba, drawn({"--zoom", "8", "--samples", "1"}).rgba);
  EXPECT_NE(four.rgba, one.rgba);
  EXPECT_EQ(drawn({"--zoom", "0.5", "--samples", "4", "--repeat", "2", "--visibility", "none"}).rgba, four.rgba);
  expectRefused({"--samples", "9"}, "--samples: expected auto, 1, 2, 4 or 16");
  expectRefused({"--samples", "2", "--lattice", "voxel"},
                "--samples 2: needs --lattice pixel, or several volumes (found --lattice voxel)");
  expectRefused({"--samples", "2", "--mode", "mip"}, "--samples 2: needs --mode composite (found --mode mip)");
}

TEST_F(SceneCli, DepthAndNormalsAreChannelsBesideTheColours) {
  const Image plain = drawn({});
  for (const char* lattice : {"pixel", "voxel"}) {
    const Image colors = drawn({"--lattice", lattice});
    EXPECT_EQ(drawnTwice({"--lattice", lattice, "--aov", "depth,normal"}).rgba, colors.rgba);
    const std::string file = readTextFile(in("a.exr"));
    for (const char* channel : {"Z", "depth.mean", "N.X", "N.Y", "N.Z"})
      EXPECT_NE(file.find(std::string("\0", 1) + channel + std::string("\0", 1)), std::string::npos) << channel;
  }
  EXPECT_EQ(drawnTwice({"--aov", "normal"}).rgba, plain.rgba);
  EXPECT_EQ(readTextFile(in("a.exr")).find("depth.mean"), std::string::npos);
  expectRefused({"--crop", "600,0,10,10"},
                "--crop: expected at least one pixel, and none outside of the picture of 8 x 8 pixels (found "
                "600,0,10,10)");
  expectRefused({"--tile", "100"}, "--tile: expected a power of two from 64 on, or 0 for the whole frame, found '100'");
  expectRefused({"--aov", "depth,colour"}, "--aov: expected one of depth, normal, value, found 'colour'");
  const ToolResult refused = runTool({"render", store_, "-o", in("r.png"), "--aov", "depth"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_EQ(refused.errorLines().size(), 1u) << refused.err;
  EXPECT_NE(refused.err.find("need a name ending in .exr"), std::string::npos) << refused.err;
}

TEST_F(SceneCli, ValuesAreProjected) {
  const Image composite = drawn({});
  for (const char* mode : {"mip", "minip", "average"}) {
    const Image colors = drawnTwice({"--mode", mode, "--window", "500,1500"});
    EXPECT_NE(colors.rgba, composite.rgba) << mode;
    EXPECT_EQ(drawnTwice({"--mode", mode, "--window", "500,1500", "--aov", "value"}).rgba, colors.rgba) << mode;
    EXPECT_NE(readTextFile(in("a.exr")).find(std::string("\0value\0", 7)), std::string::npos) << mode;
  }
  // Grey in equal steps of display values, as in slices.
  const Image grey = drawn({"--mode", "mip"});
  for (std::size_t i = 0; i < grey.rgba.size(); i += 4) EXPECT_EQ(grey.rgba[i], grey.rgba[i + 2]);
  expectRefused({"--mode", "sum"},
                "--mode: expected one of composite, mip, minip, average, attenuated-mip, found 'sum'\n");
  expectRefused({"--mode", "mpi"}, "attenuated-mip, found 'mpi'; did you mean 'mip'?");
  expectRefused({"--aov", "value"},
                "--aov: value needs --mode mip, minip, average or attenuated-mip (found --lattice pixel)");
  expectRefused({"--mode", "mip", "--aov", "depth"},
                "--aov: depth and normal need --mode composite (found --mode mip)");
  expectRefused({"--mode", "mip", "--lattice", "voxel"}, "--lattice voxel: needs --mode composite (found mip)");
  expectRefused({"--mode", "minip", "--interpolation", "cubic"},
                "--interpolation cubic: needs --mode composite (found --mode minip)");
}

// Known: a view, in place of the eye that a picture's job states, is the view of a picture of the store; a turn of the
// eye is the turn of that view, at its distance.
TEST_F(SceneCli, APicture_isDrawnAgainFromAnotherSide) {
  const auto again = [&](const std::vector<std::string>& options) {
    std::vector<std::string> words = {"render", in("a.exr"), "-o", in("again.exr")};
    words.insert(words.end(), options.begin(), options.end());
    const ToolResult result = runTool(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return readImage(in("again.exr"));
  };
  const auto from = [&](const std::string& side, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"--view", side, "--projection", "orthographic", "--fit", "box"};
    words.insert(words.end(), more.begin(), more.end());
    return drawn(words);
  };
  const Image left = from("left", {});
  const Image left_as_high = from("left", {"--height", "30"}),
              left_enlarged = from("left", {"--height", "15", "--samples", "4"});
  // Samples are given, because a picture states its own number.
  from("front", {"--height", "30"});  // the picture that is drawn again
  EXPECT_EQ(again({"--view", "left", "--fit", "box"}).rgba, left.rgba);
  EXPECT_LT(compareImages(again({"--azimuth", "90"}), left_as_high).largest, 2e-3);
  EXPECT_LT(compareImages(again({"--azimuth", "90", "--zoom", "2", "--samples", "4"}), left_enlarged).largest, 2e-3);
  // An eye replaces a view.
  const ToolResult dry = runTool({"render", in("a.exr"), "-o", in("again.exr"), "--eye", "1,2,300", "--dry-run"});
  EXPECT_EQ(dry.exit_code, 0) << dry.err;
}

TEST_F(SceneCli, APairOfEyes) {
  const Image middle = drawn({}), left = drawnTwice({"--stereo", "left", "--interocular", "3"});
  EXPECT_NE(left.rgba, middle.rgba);
  EXPECT_NE(drawnTwice({"--stereo", "right", "--interocular", "3", "--convergence", "40"}).rgba, left.rgba);
  // Known because the usual distance is a thirtieth of the depth, here of 450, in the unit of the volume, here unknown.
  const std::string usual = "is usual, here --interocular 15 (world units)";
  expectRefused({"--stereo", "left", "--convergence", "450"}, usual);
  expectRefused({"--stereo", "both", "--eye", "0,-450,1735", "--target", "0,0,1735"}, usual);
  expectRefused({"--stereo", "left", "--projection", "orthographic"}, "choose perspective");
  expectRefused({"--stereo", "middle", "--interocular", "3"}, "--stereo: expected one of left, right");
  expectRefused({"--stereo", "left", "--interocular", "3", "--projection", "orthographic"}, "choose perspective");
}

TEST_F(SceneCli, PartialImagesAreCompositedAndAttributesKept) {
  const std::vector<std::string> look = {"--background", "0.2,0.3,0.4", "--lattice", "ray", "--aov", "depth"};
  const Image whole = drawn(look);
  const std::string job = readImageText(in("a.exr")).at("kiln:job");
  for (const char* part : {"1", "2", "3"}) {
    std::vector<std::string> of_part = look;
    of_part.insert(of_part.end(), {"--part", std::string(part) + "/3"});
    drawn(of_part);
    fs::rename(in("a.exr"), in(std::string("part") + part + ".exr"));
  }
  const ToolResult made =
      runTool({"composite", in("part2.exr"), in("part3.exr"), in("part1.exr"), "-o", in("made.exr")});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(made.err, "");
  const Image image = readImage(in("made.exr"));
  ASSERT_EQ(image.rgba.size(), whole.rgba.size());
  for (std::size_t i = 0; i < image.rgba.size(); ++i) EXPECT_NEAR(image.rgba[i], whole.rgba[i], 1 / 255.0);
  EXPECT_EQ(readImageText(in("made.exr")).at("kiln:job"), job);
  const ToolResult shown =
      runTool({"composite", in("part2.exr"), in("part3.exr"), in("part1.exr"), "-o", in("made.png")});
  EXPECT_EQ(shown.exit_code, 0) << shown.err;
  EXPECT_EQ(readImageText(in("made.png")).at("kiln:job").find("aov"), std::string::npos);
  const ToolResult some = runTool({"composite", in("part2.exr"), "-o", in("some.exr")});
  EXPECT_EQ(some.exit_code, 0) << some.err;
  EXPECT_NE(some.err.find("% of the volume; the rest is missing"), std::string::npos) << some.err;
  drawn({"--part", "1/3", "--deep"});
  const ToolResult deep = runTool({"composite", in("a.exr"), "-o", in("flat.exr")});
  EXPECT_EQ(deep.exit_code, 1);
  EXPECT_NE(deep.err.find("a.exr: compositing would flatten its deep samples"), std::string::npos) << deep.err;
  EXPECT_FALSE(fs::exists(in("flat.exr")));
  expectRefused({"--part", "4/3"}, "--part: expected I/N");
  const ToolResult png = runTool({"render", store_, "-o", in("r.png"), "--part", "1/3"});
  EXPECT_EQ(png.exit_code, 2);
  EXPECT_NE(png.err.find("--part: -o of a partial image ends in .exr"), std::string::npos) << png.err;
  expectRefused({"--part", "99,0,0,120,9,9"}, "the part from 99,0,0");

  std::vector<std::string> with_texts = look;
  with_texts.insert(with_texts.end(),
                    {"--compression", "piz", "--owner", "we", "--comments", "take 3", "--exr-statistics"});
  EXPECT_EQ(drawn(with_texts).rgba, whole.rgba);
  const auto text = readImageText(in("a.exr"));
  EXPECT_EQ(text.at("owner"), "we");
  EXPECT_EQ(text.at("comments"), "take 3");
  EXPECT_NE(text.at("kiln:statistics").find("\"visited\""), std::string::npos);
  expectRefused({"--compression", "lzw"}, "--compression: expected one of none, rle");
}

// From the front, x of the camera is +x of the world, up +z, and the eye lies towards -y. A panorama looks that way,
// too.
TEST_F(SceneCli, CameraLight_isTheDirectionOfItsCamera) {
  for (const std::vector<std::string>& camera : {std::vector<std::string>{"--view", "front"},
                                                 {"--view", "front", "--projection", "orthographic"},
                                                 {"--view", "front", "--projection", "equirectangular"},
                                                 {"--view", "front", "--stereo", "left", "--interocular", "3"}}) {
    const auto lit = [&](const std::string& light) {
      std::vector<std::string> options = {"--light", light, "--tf", "viridis", "--ambient", "0"};
      options.insert(options.end(), camera.begin(), camera.end());
      return drawn(options, "40x20");
    };
    const Image of_camera = lit("cam:1,2,3:0.9,0.5,0.2");
    EXPECT_LT(compareImages(of_camera, lit("dir:1,-3,2:0.9,0.5,0.2")).largest, 2e-3) << camera.back();
    EXPECT_GT(compareImages(of_camera, lit("dir:1,3,2:0.9,0.5,0.2")).largest, 2e-2) << camera.back();
  }
  // The light turns with the camera: from behind, x of the camera is -x of the world.
  const Image behind = drawn({"--view", "back", "--light", "cam:1,2,3", "--tf", "viridis"});
  EXPECT_LT(compareImages(behind, drawn({"--view", "back", "--light", "dir:-1,3,2", "--tf", "viridis"})).largest, 2e-3);
}

}  // namespace
}  // namespace kiln::test
