// Styles of labels from ITK-SNAP's files, from a job, and by default. Known from the texts.
#include "scene/transfer/label_styles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <set>

#include "base/error.h"
#include "engine/pixel/voxels/sample_table.h"
#include "image/srgb.h"
#include "job/transfer_function_choice.h"
#include "job/transfer_function_json.h"
#include "scene/transfer/label_palette.h"
#include "scene/transfer/presets.h"
#include "scene/transfer/transfer_function_fade.h"

namespace kiln {
namespace {

constexpr const char* kSnap = R"~(################################################
# ITK-SnAP Label Description File
# File format:
# IDX   -R-  -G-  -B-  -A--  VIS MSH  LABEL
################################################
    0     0    0    0        0  0  0    "Clear Label"
   12   255    0  188      0.5  1  1    "left \"one\" # (l1)"
    3     0   51  255        1  1  0    "hidden"

    7     1    2    3        1  0  1    ""
)~";

// Three labels, 4 voxels of 0, 5 of 3 and 6 of 7.
Manifest labelManifest() {
  Manifest out;
  out.type = VoxelType::u8;
  out.volume_class = VolumeClass::kLabels;
  out.range = {0, 7};
  out.histogram = {-0.5, 7.5, {4, 0, 0, 5, 0, 0, 0, 6}};
  out.levels.emplace_back();
  return out;
}

std::string saidOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(LabelStyles, AreReadFromItkSnapsFiles) {
  EXPECT_TRUE(isLabelDescription(kSnap));
  EXPECT_TRUE(isLabelDescription("1 2 3 4 0.5 1 1 \"a\"\n"));
  EXPECT_FALSE(isLabelDescription("{\"points\": []}"));
  EXPECT_FALSE(isLabelDescription("# a comment\n[1]"));
  EXPECT_TRUE(isLabelDescription("1 2 3\n")) << "its own error names the line";
  const TransferFunction f = labelDescription(kSnap, "s.txt");
  ASSERT_EQ(f.labels.size(), 4u);
  const double labels[] = {0, 3, 7, 12}, opacities[] = {0, 0, 1, 0.5};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(f.labels[i].label, labels[i]);
    EXPECT_EQ(f.labels[i].opacity, opacities[i]);
  }
  EXPECT_EQ(f.labels[3].name, "left \\\"one\\\" # (l1)");
  EXPECT_EQ(f.labels[3].color, glm::dvec3(1, 0, linearFromSrgb(188 / 255.0)));
  EXPECT_EQ(f.at(12).opacity, 0.5);
  EXPECT_EQ(f.at(11).opacity, 0);
  EXPECT_EQ(f.at(11.5).opacity, 0);
  EXPECT_TRUE(f.labelsShownIn(7, 7));
  EXPECT_TRUE(f.labelsShownIn(8, 100));
  EXPECT_FALSE(f.labelsShownIn(0, 6));
  EXPECT_FALSE(f.labelsShownIn(13, 100));
}

// Lines of FreeSurfer's table, of a table of 3D Slicer's, and of a list beside an atlas.
TEST(LabelStyles, AreReadFromTablesAndLists) {
  const TransferFunction table = labelDescription(
      "#No. Label Name:   R   G   B   A\n\n0   Unknown   0   0   0   0\n"
      "14  3rd-Ventricle  204 182 142 0\n1004 ctx-lh-corpuscallosum 120 70 50 0\n",
      "lut.txt");
  ASSERT_EQ(table.labels.size(), 3u);
  EXPECT_EQ(table.labels[0].opacity, 0);
  EXPECT_EQ(table.labels[1].name, "3rd-Ventricle");
  EXPECT_EQ(table.labels[1].opacity, 1);
  EXPECT_EQ(table.labels[2].label, 1004);
  EXPECT_EQ(table.labels[2].color,
            glm::dvec3(linearFromSrgb(120 / 255.0), linearFromSrgb(70 / 255.0), linearFromSrgb(50 / 255.0)));
  const TransferFunction slicer =
      labelDescription("1 tissue 128 174 128 255\n2 air 0 0 0 0\n3 fat 230 220 70 51\n", "s.ctbl");
  const double opacities[] = {1, 0, 0.2};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(slicer.labels[i].opacity, opacities[i]) << i;
  const TransferFunction list =
      labelDescription("0\tUnclassified\r\n1\tGenu of corpus callosum\r\n7 Precentral_L 2001\r\n", "a.nii.txt");
  ASSERT_EQ(list.labels.size(), 3u);
  EXPECT_EQ(list.labels[0].opacity, 0);
  EXPECT_EQ(list.labels[1].name, "Genu of corpus callosum");
  EXPECT_EQ(list.labels[1].color, paletteColor(1));
  EXPECT_EQ(list.labels[1].opacity, 0.95);
  EXPECT_EQ(list.labels[2].name, "Precentral_L 2001");
  for (const char* line : {"1 2", "1 tissue 256 0 0 0 0 \"a\"", "-1 fat", "1.5 fat", "1"})
    EXPECT_NE(saidOf([&] { labelDescription(line, "s.txt"); }).find("line 1: expected a label's index"),
              std::string::npos)
        << line;
}

// MRIcron's lists count the atlas's regions in a third column. Of Brodmann's areas the number is the name.
TEST(LabelStyles, NumbersBehindNames_areNoNames) {
  const TransferFunction aal = labelDescription("1 Precentral_L 2001\n2 Precentral_R 2002\n", "aal.nii.txt");
  EXPECT_EQ(aal.labels[0].name, "Precentral_L");
  EXPECT_EQ(aal.labels[1].name, "Precentral_R");
  const TransferFunction areas = labelDescription("1 Area 17\n2 Area 18\n", "areas.txt");
  EXPECT_EQ(areas.labels[1].name, "Area 18");
  const TransferFunction mixed = labelDescription("1 Lobule 4\n2 Vermis\n", "mixed.txt");
  EXPECT_EQ(mixed.labels[0].name, "Lobule 4");
}

TEST(LabelStyles, AWrongLineIsNamed) {
  const auto said = [](const std::string& line) {
    return saidOf([&] { labelDescription("# ITK-SnAP Label Description File\n" + line, "s.txt"); });
  };
  for (const char* line : {"1 2 3 4 1 1 1 name", "1 2 3 4 1 1 \"a\"", "1 256 3 4 1 1 1 \"a\"", "1 2 3 4 1.5 1 1 \"a\"",
                           "1.5 2 3 4 1 1 1 \"a\"", "-1 2 3 4 1 1 1 \"a\"", "red", "1e9 2 3 4 1 1 1 \"a\""})
    EXPECT_NE(said(line).find("s.txt: line 2: expected a label's index"), std::string::npos) << said(line);
  EXPECT_NE(said("1 2 3 4 1 1 1 \"a\"\n1 2 3 4 1 1 1 \"b\"").find("line 3: label 1 is given twice"), std::string::npos);
  EXPECT_NE(said("# nothing").find("describes no label"), std::string::npos);
}

TEST(LabelStyles, AreCountedAndThoseOfNobodyNamed) {
  const Manifest manifest = labelManifest();
  const auto counts = labelsOf(manifest);
  ASSERT_TRUE(counts);
  ASSERT_EQ(counts->size(), 3u);
  EXPECT_EQ((*counts)[1].label, 3);
  EXPECT_EQ((*counts)[1].voxels, 5u);
  TransferFunction f;
  f.labels = {{3, "", glm::dvec3(1), 0}};
  EXPECT_NE(unknownLabelsText({f}, manifest).find("label 7 is in the volume"), std::string::npos);
  TransferFunction of_another_key;
  of_another_key.labels = {{7, "", glm::dvec3(1), 1}};
  EXPECT_EQ(unknownLabelsText({f, of_another_key}, manifest), "");
  f.labels.push_back({7, "", glm::dvec3(1), 1});
  EXPECT_EQ(unknownLabelsText({f}, manifest), "");
  EXPECT_FALSE(labelsOf(Manifest{}));
  Manifest wide = manifest;
  wide.type = VoxelType::i32, wide.range = {-1, 7};
  EXPECT_FALSE(labelsOf(wide));
}

TEST(LabelStyles, ThePaletteHasAColourForEach) {
  Manifest manifest = labelManifest();
  const TransferFunction f = presetFor("auto", manifest);
  ASSERT_EQ(f.labels.size(), 2u);
  EXPECT_EQ(f.labels[0].label, 3);
  EXPECT_EQ(f.labels[1].label, 7);
  manifest.range = {0, 300};
  manifest.histogram = {-0.5, 300.5, std::vector<std::uint64_t>(301, 1)};
  std::set<std::array<int, 3>> colors;
  for (const LabelStyle& look : labelPalette(manifest).labels) {
    std::array<int, 3> color;
    for (int c = 0; c < 3; ++c)
      color[static_cast<std::size_t>(c)] = static_cast<int>(255 * srgbFromLinear(look.color[c]));
    colors.insert(color);
  }
  EXPECT_EQ(colors.size(), 300u);
  manifest.type = VoxelType::u32;
  manifest.range = {0, 1e6};
  EXPECT_NE(saidOf([&] { labelPalette(manifest); }).find("within a range of 65536"), std::string::npos);
}

// CIE 15: 1976 L*a*b* under D65.
glm::dvec3 labOf(const glm::dvec3& linear) {
  const glm::dmat3 xyz_from_rgb(0.4124564, 0.2126729, 0.0193339, 0.3575761, 0.7151522, 0.1191920, 0.1804375, 0.0721750,
                                0.9503041);
  glm::dvec3 f = xyz_from_rgb * linear / glm::dvec3(0.95047, 1, 1.08883);
  for (int i = 0; i < 3; ++i) f[i] = f[i] > 216.0 / 24389 ? std::cbrt(f[i]) : (24389.0 / 27 * f[i] + 16) / 116;
  return {116 * f.y - 16, 500 * (f.x - f.y), 200 * (f.y - f.z)};
}

// A difference of 2.3 is just noticed side by side. Measured: 65.1 of 8, 32.5 of 32, 13.2 of 256.
TEST(LabelStyles, ColoursOfThePaletteAreFarApart) {
  const auto least = [](int labels) {
    double out = 1e9;
    for (int a = 1; a <= labels; ++a) {
      for (int b = 1; b < a; ++b) out = std::min(out, glm::distance(labOf(paletteColor(a)), labOf(paletteColor(b))));
    }
    return out;
  };
  EXPECT_GT(least(8), 60);
  EXPECT_GT(least(32), 32);
  EXPECT_GT(least(256), 13);
  EXPECT_GT(glm::distance(labOf(paletteColor(1)), labOf(paletteColor(200))), 30);
}

TEST(LabelStyles, FitLabelVolumesOnly) {
  const Manifest labels = labelManifest();
  Manifest amounts = labels;
  amounts.volume_class = VolumeClass::kUnknown;
  TransferFunction of_labels, of_points;
  of_labels.labels = {{3, "", glm::dvec3(1), 1}};
  of_points.points = {{0, glm::dvec3(1), 1}};
  const auto said = [](const TransferFunction& f, const Manifest& m, std::optional<Window> window = {}) {
    return saidOf([&] { resolve(f, window, m); });
  };
  EXPECT_EQ(said(of_labels, labels), "");
  EXPECT_EQ(said(of_points, amounts), "");
  EXPECT_NE(said(of_labels, amounts).find("convert it with --labels"), std::string::npos);
  EXPECT_NE(said(of_points, labels).find("values are labels"), std::string::npos);
  EXPECT_NE(said(of_labels, labels, Window{1, 2}).find("window"), std::string::npos);
  Manifest large = labels;
  large.range.hi = 1e9;
  EXPECT_NE(said(of_labels, large).find("number the labels anew"), std::string::npos);
}

TEST(LabelStyles, AJobSaysThem) {
  const auto from = [](const std::string& text) { return transferFunctionFrom(JobObject::parse(text, "f.json")); };
  const TransferFunction f = from(R"({"unit": 2, "colorSpace": "srgb", "labels": [
    {"label": 5, "name": "liver", "color": [1, 0, 0], "opacity": 0.25}, {"label": -2, "color": [0, 1, 0]}]})");
  ASSERT_EQ(f.labels.size(), 2u);
  EXPECT_EQ(f.labels[0].label, -2);
  EXPECT_EQ(f.labels[0].opacity, 1);
  EXPECT_EQ(f.labels[1].name, "liver");
  EXPECT_EQ(f.labels[1].opacity, 0.25);
  const auto said = [&](const std::string& text) { return saidOf([&] { from(text); }); };
  EXPECT_NE(said(R"({"labels": []})").find("at least one label"), std::string::npos);
  EXPECT_NE(said(R"({"labels": [{"label": 1}]})").find("color: is missing"), std::string::npos);
  EXPECT_NE(said(R"({"labels": [{"label": 1.5, "color": [1, 1, 1]}]})").find("whole number"), std::string::npos);
  EXPECT_NE(said(R"({"labels": [{"label": 1, "color": [1, 1, 1], "colour": 1}]})").find("unknown key"),
            std::string::npos);
  EXPECT_NE(said(R"({"labels": [{"label": 1, "color": [1, 1, 1]}, {"label": 1, "color": [1, 1, 1]}]})")
                .find("labels[1].label: is given twice"),
            std::string::npos);
  EXPECT_NE(said(R"({"labels": [{"label": 1, "color": [1, 1, 1]}], "points": []})").find("contradicts labels"),
            std::string::npos);
}

// Between two functions each label is interpolated separately.
TEST(LabelStyles, FadeOneByOne) {
  TransferFunction a, b;
  a.unit = b.unit = 1;
  a.labels = {{1, "", {1, 0, 0}, 0.8}, {2, "", {0, 1, 0}, 0.4}};
  b.labels = {{2, "", {0, 1, 0}, 0.8}, {3, "", {0, 0, 1}, 0.4}};
  const TransferFunction half = faded(a, b, 0.5);
  ASSERT_EQ(half.labels.size(), 3u);
  EXPECT_NEAR(half.at(1).opacity, 0.4, 1e-12);
  EXPECT_NEAR(half.at(2).opacity, 0.6, 1e-12);
  EXPECT_NEAR(half.at(3).opacity, 0.2, 1e-12);
  EXPECT_EQ(half.at(3).color, glm::dvec3(0, 0, 1));
}

TEST(LabelStyles, TheTableKnowsWhatARangeShows) {
  TransferFunction f;
  f.labels = {{-5, "", glm::dvec3(1), 0}, {20, "", {1, 0, 0}, 0.5}, {30000, "", {0, 1, 0}, 1}};
  const SampleTable table(f, 1, VoxelType::i16, {-100, 32000});
  EXPECT_TRUE(table.interesting({20, 20}));
  EXPECT_TRUE(table.interesting({-100, 20}));
  EXPECT_TRUE(table.interesting({21, 32000}));
  EXPECT_FALSE(table.interesting({-100, 19}));
  EXPECT_FALSE(table.interesting({21, 29999}));
  EXPECT_FALSE(table.interesting({30001, 32000}));
  EXPECT_EQ(table.rankOf(20 - static_cast<float>(table.offset())), 0);
  EXPECT_EQ(table.rankOf(30000 - static_cast<float>(table.offset())), 1);
  EXPECT_EQ(table.rankOf(-5 - static_cast<float>(table.offset())), -1);
  EXPECT_EQ(table.at(SampleTable::placeOf(1, 1)).g, 1);
  EXPECT_EQ(table.at(SampleTable::placeOf(0, 1)).tau, static_cast<float>(extinctionOf(0.5, 1)));
  EXPECT_EQ(table.at(SampleTable::placeOf(0, 0)).tau, 0);
}

TEST(LabelStyles, ColoursOfTheSource_areTheDefault) {
  Manifest manifest = labelManifest();
  const LabelStyle other = labelPalette(manifest).labels[1];
  manifest.look.labels = {{0, {255, 255, 255, 255}}, {3, {255, 0, 0, 51}}, {5, {}}};
  const std::vector<LabelStyle> labels = labelPalette(manifest).labels;
  ASSERT_EQ(labels.size(), 2u) << "0 is empty, and no voxel is 5";
  EXPECT_EQ(labels[0].label, 3);
  EXPECT_EQ(labels[0].color, glm::dvec3(1, 0, 0));
  EXPECT_EQ(labels[0].opacity, 0.2);
  EXPECT_EQ(labels[1].color, other.color);
  EXPECT_EQ(labels[1].opacity, other.opacity);
}

}  // namespace
}  // namespace kiln
