// Known answers: the light of numbers and names in both formats. A written function is read bit for bit.
#include "job/transfer_function_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "image/named_color.h"
#include "image/srgb.h"
#include "job/render_job.h"
#include "scene/transfer/presets.h"

namespace kiln {
namespace {

TransferFunction read(const std::string& text) { return transferFunctionFrom(JobObject::parse(text, "tf.json")); }

const char* const kGrey = R"("points": [{"value": 0, "color": [0.5, 0.5, 0.5], "opacity": 1}])";
const double kDecoded = linearFromSrgb(0.5);

double lightOfFile(const std::string& keys) { return read("{" + keys + kGrey + "}").points[0].color.r; }

double lightOfJob(const std::string& format, const std::string& keys) {
  const RenderJob job =
      parseJob(R"({"kiln": )" + format + R"(, "volume": "a", "transferFunction": {)" + keys + kGrey + "}}", "job.json");
  return std::get<TransferFunction>(job.picture.transfer_function).points[0].color.r;
}

TEST(TransferFunctionJson, NumbersAreLinearInFormat1AndSrgbInFormat2) {
  EXPECT_EQ(lightOfFile(""), 0.5);
  EXPECT_EQ(lightOfFile(R"("kiln": 1, )"), 0.5);
  EXPECT_EQ(lightOfFile(R"("kiln": 2, )"), kDecoded);
  EXPECT_EQ(lightOfJob("1", ""), 0.5);
  EXPECT_EQ(lightOfJob("2", ""), kDecoded);
  // A function that names its format keeps it in a job of another.
  EXPECT_EQ(lightOfJob("2", R"("kiln": 1, )"), 0.5);
  EXPECT_EQ(lightOfJob("1", R"("kiln": 2, )"), kDecoded);
  for (const char* format : {"1", "2"}) {
    EXPECT_EQ(lightOfJob(format, R"("colorSpace": "linear", )"), 0.5) << format;
    EXPECT_EQ(lightOfJob(format, R"("colorSpace": "srgb", )"), kDecoded) << format;
  }
  EXPECT_THROW(lightOfFile(R"("kiln": 3, )"), Error);
}

// The format of a job holds for functions in its lists, too.
TEST(TransferFunctionJson, KeyframesAndVolumes_haveTheJobsFormat) {
  const RenderJob job = parseJob(
      std::string(R"({"kiln": 2, "volumes": [{"volume": "a", "transferFunction": {)") + kGrey +
          R"(}}, {"volume": "b", "transferFunction": {"keyframes": [{"frame": 1, "function": {)" + kGrey + "}}]}}]}",
      "job.json");
  EXPECT_EQ(std::get<TransferFunction>(job.volumes[0].transfer_function).points[0].color.r, kDecoded);
  EXPECT_EQ(std::get<TransferFunction>(job.volumes[1].functions[0].value).points[0].color.r, kDecoded);
}

TEST(TransferFunctionJson, NamesAreDecodedWhateverTheColourSpace) {
  for (const char* keys :
       {R"("kiln": 1, )", R"("kiln": 2, )", R"("colorSpace": "linear", )", R"("colorSpace": "srgb", )"}) {
    const TransferFunction points = read(std::string("{") + keys + R"("points": [
        {"value": 0, "color": "orange", "opacity": 0}, {"value": 1, "color": "#f80", "opacity": 1}]})");
    EXPECT_EQ(points.points[0].color, *colorNamed("orange")) << keys;
    EXPECT_EQ(points.points[1].color, *colorNamed("#ff8800")) << keys;
    const TransferFunction labels = read(std::string("{") + keys + R"("labels": [
        {"label": 9, "color": "teal"}, {"label": 3, "color": "#123"}]})");
    EXPECT_EQ(labels.labels[0].color, *colorNamed("#112233")) << keys;
    EXPECT_EQ(labels.labels[1].color, *colorNamed("teal")) << keys;
  }
  try {
    read(R"({"points": [{"value": 0, "color": "oragne", "opacity": 0}]})");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(),
                 "tf.json: line 1, points[0].color: expected [red, green, blue] from 0 to 1, or a name such as orange, "
                 "#rgb or #rrggbb, found \"oragne\"");
  }
}

void expectEqual(const TransferFunction& a, const TransferFunction& b) {
  EXPECT_EQ(a.unit, b.unit);
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_EQ(a.points[i].value, b.points[i].value);
    EXPECT_EQ(a.points[i].color, b.points[i].color);
    EXPECT_EQ(a.points[i].opacity, b.points[i].opacity);
  }
  ASSERT_EQ(a.gradient_opacity.size(), b.gradient_opacity.size());
  for (std::size_t i = 0; i < a.gradient_opacity.size(); ++i) {
    EXPECT_EQ(a.gradient_opacity[i].gradient, b.gradient_opacity[i].gradient);
    EXPECT_EQ(a.gradient_opacity[i].factor, b.gradient_opacity[i].factor);
  }
  EXPECT_EQ(a.regions, b.regions);
  EXPECT_EQ(a.table, b.table);
  EXPECT_EQ(a.shaded, b.shaded);
  EXPECT_EQ(a.scattering, b.scattering);
  ASSERT_EQ(a.surfaces.size(), b.surfaces.size());
  for (std::size_t i = 0; i < a.surfaces.size(); ++i) {
    EXPECT_EQ(a.surfaces[i].value, b.surfaces[i].value);
    EXPECT_EQ(a.surfaces[i].color, b.surfaces[i].color);
    EXPECT_EQ(a.surfaces[i].opacity, b.surfaces[i].opacity);
  }
  ASSERT_EQ(a.labels.size(), b.labels.size());
  for (std::size_t i = 0; i < a.labels.size(); ++i) {
    EXPECT_EQ(a.labels[i].label, b.labels[i].label);
    EXPECT_EQ(a.labels[i].name, b.labels[i].name);
    EXPECT_EQ(a.labels[i].color, b.labels[i].color);
    EXPECT_EQ(a.labels[i].opacity, b.labels[i].opacity);
  }
}

TEST(TransferFunctionJson, SurfacesWithoutColourAndOpacity_haveTheDefaults) {
  const TransferFunction f = read(R"({"kiln": 2, "surfaces": [{"value": 3}, {"value": 4, "color": [0.5, 1, 0]}]})");
  ASSERT_EQ(f.surfaces.size(), 2u);
  EXPECT_EQ(f.surfaces[0].color, IsoSurface().color);
  EXPECT_EQ(f.surfaces[0].opacity, 1);
  EXPECT_EQ(f.surfaces[1].color.r, kDecoded);
}

TEST(TransferFunctionJson, RegionsWithoutPoints_areWhiteAndOpaque) {
  const TransferFunction f =
      read(R"({"kiln": 2, "regions": [{"values": [0, 9], "gradients": [1, 2], "color": [0.5, 1, 0]}]})");
  ASSERT_EQ(f.points.size(), 1u);
  EXPECT_EQ(f.points[0].opacity, 1);
  EXPECT_EQ(f.regions[0].color->r, kDecoded);
  EXPECT_EQ(read(R"({"kiln": 2, "points": [{"value": 0, "color": "red", "opacity": 1}], "scattering": {}})").scattering,
            Scattering());
}

// Numbers without a short decimal form.
TEST(TransferFunctionJson, WrittenFunctions_areReadBitForBit) {
  TransferFunction points{
      1 / 3.0,
      {{-1e300, {1 / 3.0, 2 / 3.0, 1e-17}, 0}, {std::nextafter(7, 8), glm::dvec3(std::sqrt(0.5)), 1 / 7.0}},
      {{0, 0}, {1 / 9.0, 1}}};
  expectEqual(read(transferFunctionText(points)), points);
  TransferFunction plane = points;
  plane.gradient_opacity.clear();
  plane.regions = {{RegionShape::kTriangle, {1 / 3.0, 2 / 3.0}, {0, 1 / 9.0}, 1 / 7.0, 1 / 3.0, glm::dvec3(1 / 3.0)},
                   {}};
  plane.scattering = {1 / 3.0, -1 / 7.0};
  expectEqual(read(transferFunctionText(plane)), plane);
  plane.regions.clear();
  plane.scattering.reset();
  plane.shaded = false;
  plane.table = {{1 / 3.0, 7}, {0, 1 / 9.0}, 2, 2, {0, 1, 1 / 3.0f, 0.1f}};
  expectEqual(read(transferFunctionText(plane)), plane);
  TransferFunction labels;
  labels.labels = {{-2, "", {1 / 3.0, 0, 1}, 0.1}, {3, "a \"liver\"\n\xc3\xa9", {0, 0, 0}, 1}};
  expectEqual(read(transferFunctionText(labels)), labels);
  TransferFunction surfaces;
  surfaces.surfaces = {{-1 / 3.0, {1 / 3.0, 0, 1}, 0.1}, {1e300, glm::dvec3(std::sqrt(0.5)), 1}};
  expectEqual(read(transferFunctionText(surfaces)), surfaces);
  Manifest manifest;
  manifest.range = {-1000 / 3.0, 3000 / 7.0};
  manifest.levels.resize(1);
  manifest.levels[0].geometry.dims = {101, 103, 107};
  for (const std::string& name : presetNames()) {
    const TransferFunction preset = presetFor(name, manifest);
    const std::string text = transferFunctionText(preset);
    expectEqual(read(text), preset);
    EXPECT_EQ(nlohmann::json::parse(text)["colorSpace"], "linear");
    EXPECT_EQ(nlohmann::json::parse(text)["kiln"], 2);
  }
}

}  // namespace
}  // namespace kiln
