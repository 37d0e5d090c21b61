// Known answers: values of VTK 9.1's vtkColorTransferFunction and vtkPiecewiseFunction for equal nodes; the published
// ends and middle of named maps.
#include "scene/transfer/color_map.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "base/error.h"
#include "image/srgb.h"
#include "job/transfer_function_choice.h"
#include "scene/transfer/named_color_maps.h"
#include "scene/transfer/preset_ranges.h"
#include "scene/transfer/presets.h"

namespace kiln {
namespace {

struct Expected {
  double value;
  glm::dvec3 srgb;
};

void expectColors(const ColorMap& map, const std::vector<Expected>& expected) {
  for (const Expected& e : expected) {
    for (int channel = 0; channel < 3; ++channel)
      EXPECT_NEAR(map.at(e.value)[channel], e.srgb[channel], 2e-5) << e.value << ", channel " << channel;
  }
}

const std::vector<ColorNode> kNodes = {{-100, {.1, .6, .3}}, {50, {.9, .2, .8}}, {300, {.05, .05, .4}}};

TEST(ColorMap, SpacesAreThoseOfVtk) {
  expectColors({ColorSpace::kRgb, kNodes}, {{-60, {0.313333333, 0.493333333, 0.433333333}},
                                            {90, {0.764, 0.176, 0.736}},
                                            {-500, {.1, .6, .3}},
                                            {500, {.05, .05, .4}}});
  expectColors({ColorSpace::kHsv, kNodes}, {{-60, {0.123407407, 0.606847831, 0.68}},
                                            {-25, {0.145833333, 0.283928571, 0.75}},
                                            {20, {0.571146667, 0.177333333, 0.84}},
                                            {180, {0.400682667, 0.109866667, 0.64}}});
  expectColors({ColorSpace::kLab, kNodes}, {{-60, {0.443311710, 0.550006588, 0.438669180}},
                                            {20, {0.789863195, 0.363109491, 0.701270953}},
                                            {260, {0.230715817, 0.067724796, 0.460991168}}});
  expectColors({ColorSpace::kDiverging, kNodes}, {{-60, {0.534244623, 0.928643777, 0.837988292}},
                                                  {-25, {0.999982842, 1, 0.999983258}},
                                                  {20, {1, 0.607742653, 0.918402140}},
                                                  {90, {0.749872967, 0.135994456, 0.736809082}}});
  expectColors({ColorSpace::kStep, kNodes},
               {{-100, {.1, .6, .3}}, {-99.9, {.9, .2, .8}}, {50, {.9, .2, .8}}, {90, {.05, .05, .4}}});
  const std::vector<ColorNode> reds = {{0, {.9, .1, .3}}, {1, {.9, .4, .1}}};
  expectColors({ColorSpace::kHsv, reds}, {{0.2, {0.64, 0.1, 0.9}}, {0.7, {0.11, 0.9, 0.1}}});
  expectColors({ColorSpace::kHsvWrapped, reds}, {{0.2, {0.9, 0.1, 0.2}}, {0.7, {0.9, 0.25, 0.1}}});
}

TEST(ColorMap, ASaturatedPairDivergesThroughWhite) {
  expectColors({ColorSpace::kDiverging, {{0, {.231373, .298039, .752941}}, {1, {.705882, .0156863, .14902}}}},
               {{0.1, {0.351735418, 0.468505687, 0.890375511}},
                {0.5, {0.865395197, 0.865410210, 0.865395561}},
                {0.9, {0.842251404, 0.326619276, 0.266613231}}});
}

// Every kind of sharpness: straight, Hermite, nearly a step, a step; midpoints left, right and in the middle.
const OpacityCurve kCurve{
    {{0, .1, .3, 0}, {10, .8, .7, .4}, {20, .2, .2, .95}, {30, .9, .5, 1}, {40, .5, .6, .05}, {50, 0, .5, 0}}};

TEST(OpacityCurve, MidpointAndSharpnessAreThoseOfVtk) {
  const std::vector<std::pair<double, double>> expected = {{-3, 0.1},         {2, 0.333333333},
                                                           {3, 0.45},         {6, 0.6},
                                                           {9, 0.75},         {12, 0.799656634},
                                                           {15, 0.760694595}, {17, 0.5},
                                                           {19, 0.200743785}, {21, 0.200012322},
                                                           {22, 0.55},        {24, 0.897979596},
                                                           {28, 0.899999992}, {31, 0.9},
                                                           {34.999, 0.9},     {35, 0.5},
                                                           {38, 0.5},         {41, 0.483755335},
                                                           {44, 0.366173840}, {46, 0.25},
                                                           {49, 0.029968262}, {60, 0}};
  for (const auto& [value, opacity] : expected) EXPECT_NEAR(kCurve.at(value), opacity, 1e-8) << value;
}

// Between its points the sampled function stays within the error bound of the map, without excessive points.
TEST(ColorMap, SamplingKeepsToItsError) {
  for (const ColorSpace space :
       {ColorSpace::kRgb, ColorSpace::kHsv, ColorSpace::kLab, ColorSpace::kDiverging, ColorSpace::kStep}) {
    const ColorMap map{space, {{-5, {.1, .6, .3}}, {22, {.9, .2, .8}}, {22, {1, 1, 0}}, {47, {.05, .05, .4}}}};
    const TransferFunction function{1, sampled(map, kCurve)};
    EXPECT_LT(function.points.size(), 400u);
    for (std::size_t i = 1; i < function.points.size(); ++i)
      ASSERT_LE(function.points[i - 1].value, function.points[i].value);
    for (int i = 0; i < 20000; ++i) {
      const double value = -6 + 58 * (i + 0.5) / 20000;
      const Classified c = function.at(value);
      EXPECT_NEAR(c.opacity, kCurve.at(value), 2 * kSampledOpacityError) << value;
      for (int channel = 0; channel < 3; ++channel)
        ASSERT_NEAR(srgbFromLinear(c.color[channel]), map.at(value)[channel], 2 * kSampledColorError)
            << value << ", space " << static_cast<int>(space);
    }
  }
}

TEST(ColorMap, NamedMapsHaveTheirPublishedColours) {
  const auto hex = [](const glm::dvec3& srgb) {
    return std::lround(srgb.r * 255) << 16 | std::lround(srgb.g * 255) << 8 | std::lround(srgb.b * 255);
  };
  EXPECT_EQ(hex(namedColorMap("viridis").at(0)), 0x440154);
  EXPECT_EQ(hex(namedColorMap("viridis").at(1)), 0xfde725);
  EXPECT_EQ(hex(namedColorMap("plasma").at(0)), 0x0d0887);
  EXPECT_EQ(hex(namedColorMap("plasma").at(1)), 0xf0f921);
  EXPECT_EQ(hex(namedColorMap("inferno").at(1)), 0xfcffa4);
  EXPECT_EQ(hex(namedColorMap("cool-to-warm").at(0.5)), 0xdddddd);
  // The tables' middle entries, between two stored entries.
  const auto within = [](const glm::dvec3& srgb, const glm::dvec3& bytes) {
    for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(255 * srgb[channel], bytes[channel], 2);
  };
  within(namedColorMap("viridis").at(127.5 / 255), {33, 145, 140});
  within(namedColorMap("plasma").at(127.5 / 255), {204, 71, 120});
  within(namedColorMap("inferno").at(127.5 / 255), {188, 55, 84});
}

class TransferFunctionFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) / ("kiln_color_map_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    manifest_.range = {-1000, 3000};
    manifest_.levels.resize(1);
    manifest_.levels[0].geometry.dims = {100, 100, 100};
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  TransferFunction read(const std::string& text, const std::string& name = "") const {
    std::ofstream(folder_ / "map.json") << text;
    return readTransferFunction((folder_ / "map.json").string() + name, manifest_);
  }
  void expectRefused(const std::string& text, const std::string& name, ErrorCode code,
                     const std::string& mentions) const {
    try {
      read(text, name);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_NE(std::string(error.what()).find(mentions), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("map.json"), std::string::npos) << error.what();
    }
  }

  std::filesystem::path folder_;
  Manifest manifest_;
};

const char* const kMaps = R"([
  {"ColorSpace": "Diverging", "Name": "Cold", "NanColor": [1, 1, 0], "DefaultMap": true,
   "RGBPoints": [0, 0.23, 0.3, 0.75, 1, 0.7, 0.016, 0.15]},
  {"ColorSpace": "RGB", "Name": "Bone", "Creator": "A. Person", "RGBPoints": [200, 1, 1, 1, -200, 0, 0, 0, 1200, 1, 0, 0],
   "Points": [200, 0, 0.5, 1, 400, 0.5, 0.5, 0, 1200, 1, 0.5, 0]}])";

// A normalised map is stretched over the range and rises in opacity as the presets do; a map with absolute values
// keeps them. A step halfway from 200 to 400 is at 300.
TEST_F(TransferFunctionFile, ParaViewMapsAreToldByTheirContent) {
  const TransferFunction cold = read(kMaps, "#Cold");
  EXPECT_EQ(cold.points.front().value, -1000);
  EXPECT_EQ(cold.points.back().value, 3000);
  EXPECT_NEAR(srgbFromLinear(cold.at(1000).color.g), 0.8654, 0.004);
  EXPECT_EQ(cold.at(-1000).opacity, 0);
  EXPECT_NEAR(cold.at(3000).opacity, risingOpacity(manifest_.range, manifest_).at(3000), 1e-12);
  const TransferFunction bone = read(kMaps, "#Bone");
  EXPECT_EQ(bone.points.front().value, -200);
  EXPECT_NEAR(srgbFromLinear(bone.at(0).color.r), 0.5, 0.004);
  EXPECT_EQ(bone.at(299).opacity, 0);
  EXPECT_EQ(bone.at(301).opacity, 0.5);
  EXPECT_NEAR(bone.at(800).opacity, 0.75, 1e-9);
  EXPECT_EQ(bone.at(2000).opacity, 1);
  EXPECT_EQ(read(R"({"points": [{"value": 3, "color": [1, 1, 1], "opacity": 0.5}]})").at(3).opacity, 0.5);
  EXPECT_EQ(read(R"([{"RGBPoints": [5, 0, 0, 0, 9, 1, 1, 1]}])").points.back().value, 9);
}

TEST_F(TransferFunctionFile, MistakesNameTheFileAndTheKey) {
  expectRefused(kMaps, "", ErrorCode::kUsage, "FILE#NAME with one of: Cold, Bone");
  expectRefused(kMaps, "#Warm", ErrorCode::kUsage, "no map named 'Warm'; there are Cold, Bone");
  expectRefused("[]", "", ErrorCode::kUsage, "empty list");
  expectRefused(R"({"RGBPoints": [0, 0, 0, 0, 1]})", "", ErrorCode::kUsage, "RGBPoints: expected [value");
  expectRefused(R"({"RGBPoints": [0, 0, 0, 255]})", "", ErrorCode::kUsage, "RGBPoints: expected [value");
  expectRefused(R"({"RGBPoints": [0, 0, 0, 0], "Points": [0, 0, 2, 0]})", "", ErrorCode::kUsage, "Points: expected");
  expectRefused(R"({"RGBPoints": [0, 0, 0, 0], "ColorSpace": "XYZ"})", "", ErrorCode::kUsage, "ColorSpace: expected");
  expectRefused(R"({"IndexedColors": [0, 0, 0]})", "", ErrorCode::kUsage, "RGBPoints: is missing");
  expectRefused(R"({"RGBPoints": [1, 0, 0, 0], "UseLogScale": 1})", "", ErrorCode::kUnsupported, "UseLogScale");
  expectRefused(R"([{"Name": "x", "RGBPoints": 3}])", "", ErrorCode::kUsage, "[0].RGBPoints");
  expectRefused("[3]", "", ErrorCode::kUsage, "[0]: expected an object");
}

// A window replaces the range; a single point moves to the window's centre.
TEST_F(TransferFunctionFile, AWindowStretchesWhatIsThere) {
  const Window window{50, 400};
  const TransferFunction gray = resolve(std::string("grayscale"), window, manifest_);
  EXPECT_EQ(gray.points.front().value, -150);
  EXPECT_EQ(gray.points.back().value, 250);
  EXPECT_NEAR(gray.at(50).color.r, 0.5, 1e-12);
  EXPECT_EQ(gray.unit, 1);
  const TransferFunction solid = resolve(std::string("solid:2000"), Window{300, 2}, manifest_);
  EXPECT_EQ(solid.points.front().value, 299);
  const TransferFunction iso = resolve(std::string("iso:1,2,5"), window, manifest_);
  EXPECT_EQ(iso.surfaces[1].value, -50);
  EXPECT_EQ(iso.surfaces[2].value, 250);
  EXPECT_EQ(resolve(std::string("iso:7"), window, manifest_).surfaces[0].value, 50);
  EXPECT_EQ(resolve(TransferFunction{0, {{7, {1, 1, 1}, 1}}}, window, manifest_).points.front().value, 50);
}

}  // namespace
}  // namespace kiln
