// Annotated pictures as users see them: layers of an EXR, pictures composited, crops, tiles and ranks equal to the
// whole, and each wrong combination refused in one line.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "base/file/file.h"
#include "image/file/image_file.h"
#include "image/srgb.h"
#include "support/reference/drawing.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

const std::vector<std::string> kAll = {"--scale-bar", "--box",  "--legend", "--legend-title",
                                       "value",       "--axes", "--text",   "{volume} {frame}"};
const std::vector<std::string> kLayer = {"annotation.R", "annotation.G", "annotation.B", "annotation.A"};

class AnnotationsCli : public ToolTest {
 protected:
  AnnotationsCli() : ToolTest("annotations_") {}
  void SetUp() override { done({"convert", "phantom:head:40x40x40", in("h.kiln"), "--brick-size", "16"}); }

  // `kiln render h.kiln -o NAME --size 160x120 OPTIONS`, with all annotations.
  std::vector<std::string> render(const std::string& name, std::vector<std::string> options = {},
                                  bool annotated = true) const {
    options.insert(options.begin(), {"render", in("h.kiln"), "-o", in(name), "--size", "160x120", "--fit", "visible"});
    if (annotated) options.insert(options.end(), kAll.begin(), kAll.end());
    return options;
  }
  void drawn(const std::string& name, const std::vector<std::string>& options = {}, bool annotated = true) const {
    done(render(name, options, annotated));
  }
  Image read(const std::string& name, const std::vector<std::string>& planes = {}) const {
    return readImage(in(name), planes);
  }
  // l.kiln: labels in the box of the head, 1 in its lower half and 2 in its upper half.
  void makeLabels() const {
    writeText(in("l.nrrd"),
              "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspace: left-posterior-superior\n"
              "space directions: (72,0,0) (0,72,0) (0,0,63)\nspace origin: (-108,-108,1639)\n"
              "space units: \"mm\" \"mm\" \"mm\"\nencoding: raw\n\n" +
                  std::string(32, 1) + std::string(32, 2));
    done({"convert", in("l.nrrd"), in("l.kiln"), "--labels"});
  }
  void refused(std::vector<std::string> options, const std::string& mention) const {
    options.insert(options.begin(), {"render", in("h.kiln")});
    ToolTest::refused(options, 2, mention);
  }
};

double inkOf(const Image& image) {
  double out = 0;
  for (const float alpha : image.planes.back().values) out += alpha;
  return out;
}

TEST_F(AnnotationsCli, AnExrHasTheLayerBesideEqualColours) {
  // A camera that leaves no room for the legend.
  const std::vector<std::string> options = {"--exr-type", "float", "--target", "0,0,1735"};
  std::vector<std::string> with_depth = options;
  with_depth.insert(with_depth.end(), {"--aov", "depth"});
  drawn("plain.exr", options, false);
  drawn("layer.exr", options);
  drawn("depth.exr", with_depth);
  const Image plain = read("plain.exr"), layer = read("layer.exr", kLayer), depth = read("depth.exr", kLayer);
  EXPECT_EQ(plain.rgba, layer.rgba);
  EXPECT_GT(inkOf(layer), 500);
  // The outline is hidden by depth whether the file holds the depth or not.
  for (std::size_t i = 0; i < kLayer.size(); ++i) EXPECT_EQ(layer.planes[i].values, depth.planes[i].values);
  std::set<std::string> channels;
  for (const auto& [name, type] : readPixelLayout(in("layer.exr")).channels) channels.insert(name);
  std::set<std::string> expected = {"R", "G", "B", "A"};
  expected.insert(kLayer.begin(), kLayer.end());
  EXPECT_EQ(channels, expected);
}

// The pixels of the object in the rectangle around all ink, and the ink's own pixels.
std::pair<std::size_t, std::size_t> pixelsUnderInk(const Image& layer) {
  PixelRect around{layer.width, layer.height, 0, 0};
  std::size_t object = 0, ink = 0;
  const auto inkAt = [&](int x, int y) {
    return layer.planes.back().values[static_cast<std::size_t>(y * layer.width + x)];
  };
  for (int y = 0; y < layer.height; ++y) {
    for (int x = 0; x < layer.width; ++x) {
      if (inkAt(x, y) == 0) continue;
      ++ink;
      around = {std::min(around.x0, x), std::min(around.y0, y), std::max(around.x1, x + 1), std::max(around.y1, y + 1)};
    }
  }
  for (int y = around.y0; y < around.y1; ++y) {
    for (int x = around.x0; x < around.x1; ++x) object += layer.pixel(x, y)[3] > 0.02f ? 1 : 0;
  }
  return {object, ink};
}

// Known: a camera that fits the object leaves the rectangle of the legend free, in each frame of a turn.
TEST_F(AnnotationsCli, NothingIsDrawnUnderALegend) {
  makeLabels();
  writeText(in("names.txt"), "1 255 0 0 1 1 1 \"lower half\"\n2 0 0 255 1 1 1 \"upper half\"\n");
  const std::vector<std::string> ct = {in("h.kiln"), "--tf", "ct-skin"},
                                 labels = {in("l.kiln"), "--tf", in("names.txt")};
  const std::vector<std::vector<std::string>> kinds = {
      {"--size", "130x120"},
      {"--size", "130x120", "--projection", "orthographic", "--view", "left"},
      {"--size", "240x100", "--legend-position", "left", "--legend-title", "a title"},
      {"--size", "120x200"},
      {"--size", "200x150", "--legend-position", "bottom-left"},
      {"--size", "160x120", "--fit", "box", "--view", "front"},
      {"--size", "160x120", "--zoom", "0.7"},
      {"--size", "130x120", "--turntable", "8", "--frames", "1,2,4"},
      {"--size", "130x120", "--turntable", "8", "--frames", "3,8", "--projection", "orthographic", "--roll", "30"}};
  for (const std::vector<std::string>& volume : {ct, labels}) {
    for (const std::vector<std::string>& kind : kinds) {
      const bool film = std::ranges::find(kind, "--turntable") != kind.end();
      std::vector<std::string> words = {"render", "-o", in(film ? "f_#.exr" : "f_1.exr"), "--legend"};
      words.insert(words.end(), volume.begin(), volume.end());
      words.insert(words.end(), kind.begin(), kind.end());
      done(words);
      for (const int frame : {1, 2, 3, 4, 8}) {
        const std::string file = "f_" + std::to_string(frame) + ".exr";
        if (!fs::exists(in(file))) continue;
        const auto [object, ink] = pixelsUnderInk(read(file, kLayer));
        EXPECT_EQ(object, 0u) << fmt::format("{}", fmt::join(words, " ")) << ", frame " << frame;
        EXPECT_GT(ink, 500u);
        fs::remove(in(file));
      }
    }
  }
}

// Known: a short legend may have rows or columns, a list of 20 surfaces columns only, and both frames have one camera.
TEST_F(AnnotationsCli, NothingIsDrawnUnderALongerLegendOfAFilm) {
  std::string many = "iso:600";
  for (int value = 650; value < 1600; value += 50) many += "," + std::to_string(value);
  writeText(in("film.json"), R"({"kiln": 2, "volume": "h.kiln", "transferFunction": {"keyframes": [
      {"frame": 1, "function": "iso:600"}, {"frame": 2, "function": ")" +
                                 many + R"("}]}})");
  done({"render", in("film.json"), "-o", in("f_#.exr"), "--legend", "--legend-position", "bottom-right", "--size",
        "340x460"});
  for (const char* const file : {"f_1.exr", "f_2.exr"}) {
    const auto [object, ink] = pixelsUnderInk(read(file, kLayer));
    EXPECT_EQ(object, 0u) << file;
    EXPECT_GT(ink, 100u);
  }
}

TEST_F(AnnotationsCli, AScaleBarWithoutRoomIsWarnedOf) {
  std::vector<std::string> words = render("long.png", {"--scale-bar", "--scale-bar-length", "50"}, false);
  EXPECT_EQ(done(words).err.find("--scale-bar-length"), std::string::npos);
  words.back() = "5000";
  EXPECT_NE(done(words).err.find("apart at its target (found 5000 mm)"), std::string::npos);
  // A bar of no given length has 22 % of the width, and fits unless the margins take more than 78 %.
  const ToolResult narrow = done({"render", in("h.kiln"), "-o", in("narrow.png"), "--size", "12x400", "--scale-bar"});
  EXPECT_NE(narrow.err.find("--scale-bar: the bar must fit"), std::string::npos) << narrow.err;
  EXPECT_NE(narrow.err.find("give a larger --size"), std::string::npos) << narrow.err;
}

// Known: "over", in linear light.
TEST_F(AnnotationsCli, APngIsTheLayerOverTheColours) {
  const std::vector<std::string> options = {"--exr-type", "float", "--background", "navy:0.2,0.2,0.2"};
  drawn("layer.exr", options);
  drawn("flat.png", {"--background", "navy:0.2,0.2,0.2", "--png-bits", "16"});
  const Image layer = read("layer.exr", kLayer), flat = read("flat.png");
  double worst = 0;
  for (int y = 0; y < flat.height; ++y) {
    for (int x = 0; x < flat.width; ++x) {
      const auto place = static_cast<std::size_t>(y * flat.width + x);
      const float open = 1 - layer.planes[3].values[place];
      for (int channel = 0; channel < 3; ++channel) {
        const double expected =
            layer.planes[static_cast<std::size_t>(channel)].values[place] + open * layer.pixel(x, y)[channel];
        worst = std::max(worst,
                         std::abs(srgbFromLinear(std::min(expected, 1.0)) - srgbFromLinear(flat.pixel(x, y)[channel])));
      }
    }
  }
  EXPECT_LT(worst, 2e-4);
}

TEST_F(AnnotationsCli, CropsAreThePixelsOfTheWhole) {
  for (const std::string ending : {".png", ".exr"}) {
    drawn("whole" + ending);
    drawn("crop" + ending, {"--crop", "83,20,70,90"});
    const std::vector<std::string> planes = ending == ".exr" ? kLayer : std::vector<std::string>{};
    const Image whole = read("whole" + ending, planes);
    EXPECT_TRUE(equalBits(partOf(whole, {83, 20, 153, 110}), read("crop" + ending, planes))) << ending;
  }
}

TEST_F(AnnotationsCli, CheckpointsGiveEqualFiles) {
  for (const char* const name : {"whole.png", "whole.exr"}) {
    const std::string tiles = std::string("tiles_") + name;
    drawn(name, {"--tone", "soft", "--exposure", "0.5"});
    drawn(tiles, {"--tone", "soft", "--exposure", "0.5", "--checkpoint"});
    EXPECT_EQ(readFile(in(name)), readFile(in(tiles))) << name;
  }
}

TEST_F(AnnotationsCli, RanksGiveEqualFiles) {
  if (!canRunRanks()) GTEST_SKIP() << "mpirun is not here";
  drawn("alone.png");
  for (const char* const share : {"tiles", "frames", "bricks"}) {
    const ToolResult result = runTool(render("ranks.png", {"--distribute", share}), {.ranks = 2});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const Image alone = read("alone.png"), ranks = read("ranks.png");
    double worst = 0;
    for (std::size_t i = 0; i < alone.rgba.size(); ++i)
      worst = std::max<double>(worst, std::abs(srgbFromLinear(alone.rgba[i]) - srgbFromLinear(ranks.rgba[i])));
    EXPECT_LE(worst, std::string(share) == "bricks" ? 2.0 / 255 : 0.0) << share;
  }
}

// The number of the frame is part of its picture: a file of another frame is refused.
TEST_F(AnnotationsCli, ResumeKnowsTheTextOfAFrame) {
  drawn("f_#.png", {"--frames", "1,2"});
  EXPECT_NE(readFile(in("f_1.png")), readFile(in("f_2.png")));
  const std::vector<std::string> again = render("f_#.png", {"--frames", "1,2", "--resume"});
  done(again);
  fs::copy_file(in("f_2.png"), in("f_1.png"), fs::copy_options::overwrite_existing);
  ToolTest::refused(again, 1, "annotations.text is");
}

// The job in a header draws the same picture again, braces included.
TEST_F(AnnotationsCli, TheJobOfAHeaderDrawsAnEqualPicture) {
  drawn("a.exr",
        {"--frames", "7", "--text", "{{{frame}}} of {volume}: {minimum} to {maximum}, {voxels}, {time}",
         "--annotation-color", "orange", "--annotation-size", "1.5", "--axes"},
        false);
  done({"render", in("a.exr"), "-o", in("b.exr")});
  const Image a = read("a.exr", kLayer), b = read("b.exr", kLayer);
  for (std::size_t i = 0; i < kLayer.size(); ++i) EXPECT_EQ(a.planes[i].values, b.planes[i].values);
}

// The resolved text is the header's. The phantom is in mm; a file without a unit has world units, as kiln info prints.
TEST_F(AnnotationsCli, UnitsOfTexts_areNamedAlsoIfUnknown) {
  const auto text = [&](const std::string& store) {
    done({"render", in(store), "-o", in("u.exr"), "--size", "96x64", "--text", "in {unit}."});
    return readImageText(in("u.exr")).at("kiln:job");
  };
  EXPECT_NE(text("h.kiln").find("in mm."), std::string::npos);
  writeText(in("n.nrrd"), "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 8\nencoding: raw\n\n" + std::string(256, 1) +
                              std::string(256, 2));
  done({"convert", in("n.nrrd"), in("n.kiln")});
  EXPECT_NE(text("n.kiln").find("in world units."), std::string::npos);
}

// A range of labels or counts beyond a million keeps its last digit.
TEST_F(AnnotationsCli, RangeOfWholeValues_isExact) {
  writeText(in("n.nrrd"), "NRRD0004\ntype: uint32\ndimension: 3\nsizes: 1 1 2\nencoding: text\n\n1234567 1234568\n");
  done({"convert", in("n.nrrd"), in("n.kiln")});
  done({"render", in("n.kiln"), "-o", in("n.exr"), "--size", "96x64", "--text", "{minimum} to {maximum}"});
  EXPECT_NE(readImageText(in("n.exr")).at("kiln:job").find("1234567 to 1234568"), std::string::npos);
}

TEST_F(AnnotationsCli, BothEyesAreAnnotated) {
  const std::vector<std::string> pair = {"--stereo", "both", "--interocular", "4"};
  drawn("both.png", pair);
  drawn("plain.png", pair, false);
  const Image both = read("both.png"), without = read("plain.png");
  for (const int eye : {0, 1}) {
    std::size_t different = 0;
    for (int y = 0; y < both.height; ++y) {
      for (int x = eye * 160; x < (eye + 1) * 160; ++x)
        different += std::equal(both.pixel(x, y), both.pixel(x, y) + 4, without.pixel(x, y)) ? 0 : 1;
    }
    EXPECT_GT(different, 500u) << eye;
  }
  drawn("left.png", {"--stereo", "left", "--interocular", "4"});
  EXPECT_TRUE(equalBits(partOf(both, {0, 0, 160, 120}), read("left.png")));
  drawn("both.exr", pair);
  EXPECT_GT(inkOf(read("both.exr", kLayer)), 500);
}

TEST_F(AnnotationsCli, SheetsProjectionsAndPanoramasAreAnnotated) {
  drawn("sheet.png", {"--turntable", "12", "--sheet", "2"});
  drawn("plain.png", {"--turntable", "12", "--sheet", "2"}, false);
  EXPECT_NE(readFile(in("sheet.png")), readFile(in("plain.png")));
  drawn("mip.exr", {"--mode", "mip"});
  EXPECT_GT(inkOf(read("mip.exr", kLayer)), 500);
  done({"render", in("h.kiln"), "-o", in("around.exr"), "--size", "128x64", "--projection", "equirectangular", "--text",
        "around", "--legend"});
  EXPECT_GT(inkOf(read("around.exr", kLayer)), 50);
}

// Known: the colours of two labels that the volume has; a third label of the table has no voxel and no swatch.
TEST_F(AnnotationsCli, LegendsShowTheColoursOfAnotherVolume) {
  makeLabels();
  writeText(in("names.txt"), "1 255 0 0 1 1 1 \"low\"\n2 0 0 255 1 1 1 \"high\"\n5 0 255 0 1 1 1 \"absent\"\n");
  const auto swatches = [&](const std::vector<std::string>& options) {
    std::vector<std::string> all = {"--legend", "--tf", "ct-bone"};
    all.insert(all.end(), options.begin(), options.end());
    drawn("c.exr", all, false);
    const Image layer = read("c.exr", kLayer);
    std::set<int> out;
    for (int y = 0; y < layer.height; ++y) {
      for (int x = layer.width / 2; x < layer.width; ++x) {
        for (int c = 0; c < 3; ++c) {
          const auto at = [&](int channel) {
            return layer.planes[static_cast<std::size_t>(channel)]
                .values[static_cast<std::size_t>(y * layer.width + x)];
          };
          if (at(c) > 0.99f && at((c + 1) % 3) < 0.01f && at((c + 2) % 3) < 0.01f) out.insert(c);
        }
      }
    }
    return out;
  };
  EXPECT_EQ(swatches({}), std::set<int>());
  EXPECT_EQ(swatches({"--color-by", in("l.kiln") + ":" + in("names.txt")}), (std::set<int>{0, 2}));
  EXPECT_EQ(swatches({"--labels", in("l.kiln"), "--add-tf", in("names.txt")}), (std::set<int>{0, 2}));
}

// The phantom is in LPS. Known: letters change pixels at the edges alone.
TEST_F(AnnotationsCli, SlicesHaveLettersAtTheirEdges) {
  const auto slice = [&](const std::string& name, std::vector<std::string> options) {
    options.insert(options.begin(), {"slice", in("h.kiln"), "-o", in(name)});
    return done(options).out;
  };
  for (const std::vector<std::string>& kind :
       {std::vector<std::string>{"--axis", "coronal"}, {"--plane", "0,1,0,-99"}, {"--sheet"}}) {
    std::vector<std::string> plain = kind;
    plain.push_back("--no-letters");
    slice("letters.png", kind);
    slice("plain.png", plain);
    const Image with = read("letters.png"), without = read("plain.png");
    ASSERT_EQ(with.width, without.width);
    EXPECT_NE(with.rgba, without.rgba) << kind[0];
  }
  EXPECT_NE(slice("c.png", {"--axis", "coronal"}).find("coronal"), std::string::npos);
  slice("letters.exr", {"--axis", "coronal"});
  slice("plain.exr", {"--axis", "coronal", "--no-letters"});
  const Image layer = read("letters.exr", kLayer);
  EXPECT_EQ(layer.rgba, read("plain.exr").rgba);
  ASSERT_GT(inkOf(layer), 10);
  const auto inkAt = [&](int x0, int y0, int x1, int y1) {
    double out = 0;
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) out += layer.planes.back().values[static_cast<std::size_t>(y * layer.width + x)];
    return out;
  };
  const int w = layer.width, h = layer.height, room = 19;
  for (const double ink : {inkAt(0, room, room, h - room), inkAt(w - room, room, w, h - room),
                           inkAt(room, 0, w - room, room), inkAt(room, h - room, w - room, h)})
    EXPECT_GT(ink, 5);
  EXPECT_EQ(inkAt(room, room, w - room, h - room), 0);
  // The planes of an EXR are charged.
  ToolTest::refused({"slice", in("h.kiln"), "-o", in("letters.exr"), "--memory", "64K"}, 1, "--memory");
}

TEST_F(AnnotationsCli, EmptyTexts_clearThoseOfAJob) {
  const auto job = [&](const std::string& more) {
    writeText(
        in("job.json"),
        R"({"kiln": 2, "volume": "h.kiln", "image": {"width": 96, "height": 72}, "annotations": {"legend": true)" +
            more + "}}");
  };
  job(R"(, "text": "take 3", "legendTitle": "HU")");
  done({"render", in("job.json"), "-o", in("cleared.png"), "--text", "", "--legend-title="});
  done({"render", in("job.json"), "-o", in("texts.png")});
  job("");
  done({"render", in("job.json"), "-o", in("none.png")});
  EXPECT_EQ(read("cleared.png").rgba, read("none.png").rgba);
  EXPECT_NE(read("texts.png").rgba, read("none.png").rgba);
}

TEST_F(AnnotationsCli, WrongCombinationsAreRefused) {
  refused({"-o", in("a.exr"), "--part", "1/2", "--box"}, "--part: a partial image is not finished");
  refused({"-o", in("a.png"), "--projection", "equirectangular", "--axes"}, "a panorama has no scale bar");
  refused({"-o", in("a.png"), "--legend-title", "HU"}, "--legend-title: no legend is drawn");
  refused({"-o", in("a.png"), "--text", "{fraem}"}, "{fraem}");
  refused({"-o", in("a.png"), "--text", "a}"}, "--text: expected a text with placeholders");
  refused({"-o", in("a.exr"), "--deep", "--scale-bar"}, "annotations: are drawn over colours");
  refused({"-o", in("a.png"), "--annotation-size", "0.1"}, "--annotation-size: expected");
  refused({"-o", in("a.png"), "--annotation-color", "inky"}, "--annotation-color: expected");
  writeText(in("job.json"), R"({"kiln": 2, "volume": "h.kiln", "output": "a.png", "annotations": {"text": "{x}"}})");
  ToolTest::refused({"render", in("job.json")}, 2, "annotations.text: expected a text with placeholders");
}

}  // namespace
}  // namespace kiln::test
