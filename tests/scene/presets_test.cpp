// Known answers: two peaks in a histogram force Otsu's threshold between them. CT presets are quoted in Hounsfield
// units, so the values of air, skin and bone are known in each scale. By their description, the heads of Stanford's
// archive have skin from about 500 and bone from about 1150.
#include "scene/transfer/presets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "scene/transfer/preset_ranges.h"

namespace kiln {
namespace {

struct Peak {
  double value;
  std::uint64_t voxels;
};

Manifest volumeOf(VoxelType type, double lo, double hi, const std::vector<Peak>& peaks) {
  Manifest manifest;
  manifest.type = type;
  manifest.range = {lo, hi};
  manifest.histogram = {lo, hi, std::vector<std::uint64_t>(256)};
  for (const Peak& peak : peaks) {
    const double bin = hi > lo ? (peak.value - lo) / (hi - lo) * 256 : 0;
    manifest.histogram.counts[static_cast<std::size_t>(std::min(bin, 255.0))] += peak.voxels;
  }
  manifest.levels.resize(1);
  manifest.levels[0].geometry.dims = {100, 100, 100};
  return manifest;
}

// Air, soft tissue, bone, and teeth, as in the UNC head.
Manifest ctHead(double shift, VoxelType type) {
  return volumeOf(type, shift - 1024, shift + 2248,
                  {{shift - 1000, 700000}, {shift + 50, 220000}, {shift + 700, 70000}, {shift + 2248, 10000}});
}

TEST(Presets, NamesAreInOrderAndAllWork) {
  const Manifest head = ctHead(1024, VoxelType::u16);
  EXPECT_EQ(presetNames().front(), "auto");
  for (const std::string& name : presetNames()) {
    const TransferFunction f = presetFor(name, head);
    EXPECT_EQ(f.unit, 0) << name;
    EXPECT_TRUE(std::is_sorted(f.points.begin(), f.points.end(), [](const TransferPoint& a, const TransferPoint& b) {
      return a.value < b.value;
    })) << name;
  }
}

TEST(Presets, AnUnknownNameListsThoseThereAre) {
  try {
    presetFor("ct-bones", ctHead(0, VoxelType::i16));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    for (const std::string& name : presetNames()) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos);
    }
  }
}

TEST(Presets, CtIsTheSameInHounsfieldAndShifted) {
  for (const double shift : {0.0, 1024.0}) {
    const Manifest head = ctHead(shift, shift == 0 ? VoxelType::i16 : VoxelType::u16);
    const TransferFunction skin = presetFor("ct-skin", head), bone = presetFor("ct-bone", head);
    EXPECT_FALSE(skin.interesting(shift - 900));  // air
    EXPECT_GT(skin.at(shift + 0).opacity, 0.8);   // skin
    EXPECT_FALSE(bone.interesting(shift + 80));   // muscle, brain
    EXPECT_GT(bone.at(shift + 500).opacity, 0.8);
  }
}

TEST(Presets, CtFollowsTheDescriptionOfTheUncHead) {
  const Manifest head = ctHead(1024, VoxelType::u16);
  EXPECT_NEAR(presetFor("ct-skin", head).points.front().value, 500, 50);
  EXPECT_NEAR(presetFor("ct-bone", head).points.front().value, 1150, 50);
}

// Values of tissues in Hounsfield units; each preset shows some and hides the others.
TEST(Presets, CtPresets_showTheTissueOfTheirName) {
  constexpr double kAir = -1000, kLung = -750, kFat = -90, kMuscle = 60, kContrast = 300, kBone = 1000, kEnamel = 2300;
  struct Shown {
    const char* name;
    std::vector<double> visible, hidden;
  };
  const Shown presets[] = {
      {"ct-skin", {kMuscle, kBone}, {kAir, kLung}},
      {"ct-bone", {kBone, kEnamel}, {kAir, kLung, kFat, kMuscle}},
      {"ct-bone-and-skin", {kBone, -300}, {kAir, kMuscle}},
      {"ct-muscle", {kMuscle, kBone}, {kAir, kLung, kFat}},
      {"ct-fat", {kFat, kBone}, {kAir, kLung, kMuscle}},
      {"ct-lung", {kLung}, {kAir, kFat, kMuscle, kBone}},
      {"ct-vessels", {kContrast, kBone}, {kAir, kLung, kFat, kMuscle}},
      {"ct-teeth", {kEnamel}, {kAir, kLung, kFat, kMuscle}},
      {"ct-xray", {kFat, kMuscle, kBone}, {kAir, kLung}},
  };
  std::size_t of_list = 0;
  for (const std::string& name : presetNames()) of_list += name.starts_with("ct-") ? 1 : 0;
  EXPECT_EQ(of_list, std::size(presets));
  for (const double shift : {0.0, 1024.0}) {
    const Manifest head = ctHead(shift, shift == 0 ? VoxelType::i16 : VoxelType::u16);
    for (const Shown& preset : presets) {
      const TransferFunction f = presetFor(preset.name, head);
      for (const double value : preset.visible)
        EXPECT_TRUE(f.interesting(shift + value)) << preset.name << ' ' << value;
      for (const double value : preset.hidden)
        EXPECT_FALSE(f.interesting(shift + value)) << preset.name << ' ' << value;
    }
    for (const char* name : {"ct-bone", "ct-skin", "ct-muscle", "ct-bone-and-skin"})
      EXPECT_GE(presetFor(name, head).at(shift + kBone).opacity, 0.9) << name;
    // A radiograph absorbs more where there is more matter.
    const TransferFunction film = presetFor("ct-xray", head);
    EXPECT_LT(film.at(shift + kFat).opacity, film.at(shift + kMuscle).opacity);
    EXPECT_LT(film.at(shift + kMuscle).opacity, film.at(shift + kBone).opacity);
    EXPECT_FALSE(film.shaded);
  }
}

// Known because twice the voxels along each axis in the same box are the same object: its optical depth is the same. A
// surface has its opacity within a voxel. Volumes of up to 768 voxels across keep an opacity per voxel.
TEST(Presets, TissueThatIsSeenThrough_isAsTransparentInMoreVoxels) {
  const auto headOf = [](const Extent3& dims, double spacing) {
    Manifest out = ctHead(0, VoxelType::i16);
    out.levels[0].geometry.dims = dims;
    for (int axis = 0; axis < 3; ++axis) out.levels[0].geometry.world_from_index[axis][axis] = spacing;
    return out;
  };
  const Manifest small = headOf({512, 512, 240}, 1), large = headOf({1024, 1024, 1024}, 0.5),
                 larger = headOf({2048, 2048, 2048}, 0.25);
  for (const std::string& name : presetNames()) {
    if (!name.starts_with("ct-")) continue;
    EXPECT_EQ(presetFor(name, small).unit, 0) << name;
    const double unit = presetFor(name, large).unit;
    const bool surface = name == "ct-skin" || name == "ct-bone";
    EXPECT_NEAR(unit, surface ? 0 : 512 * std::sqrt(3.0) / 768, 1e-9) << name;
    EXPECT_NEAR(presetFor(name, larger).unit, unit, 1e-12) << name;
  }
}

// Known because the default light adds a highlight of 0.2 to a tint.
TEST(Presets, TintsOfTissues_leaveRoomForAHighlight) {
  for (const std::string& name : presetNames()) {
    if ((!name.starts_with("ct-") && !name.starts_with("mr-") && name != "auto") || name == "ct-xray") continue;
    for (const TransferPoint& point : presetFor(name, ctHead(0, VoxelType::i16)).points)
      EXPECT_LE(std::max({point.color.r, point.color.g, point.color.b}), 0.8) << name;
  }
}

// Otsu's threshold is between the peaks of air and tissue; the head's box has a diagonal of 173 voxels.
TEST(Presets, ColourMaps_beginAboveEmptySpaceAndRise) {
  const Manifest head = ctHead(0, VoxelType::i16);
  for (const char* name : {"grayscale", "viridis", "plasma", "inferno", "cool-to-warm", "fire"}) {
    const TransferFunction f = presetFor(name, head);
    EXPECT_FALSE(f.interesting(-1000)) << name;
    EXPECT_GT(f.points.front().value, -1000) << name;
    EXPECT_LT(f.points.front().value, 50) << name;
    EXPECT_GT(f.at(50).opacity, 0) << name;
    EXPECT_GT(f.at(700).opacity, 2 * f.at(50).opacity) << name;
    EXPECT_NEAR(extinctionOf(f.points.back().opacity, 1) * 100 * std::sqrt(3.0), 300, 1e-9) << name;
  }
  // A fog has no empty space but 0.
  Manifest cloud = volumeOf(VoxelType::f32, 0, 4, {{0, 900000}, {1, 90000}, {3.99, 10000}});
  cloud.volume_class = VolumeClass::kFog;
  EXPECT_EQ(presetFor("fire", cloud).points.front().value, 0);
  EXPECT_NEAR(presetFor("fire", cloud).at(2).opacity, 0.5 * presetFor("fire", cloud).at(4).opacity, 2e-3);
}

// Empty space, brain and one hundredth of bright blood.
TEST(Presets, MrAngiogram_showsTheBrightestHundredth) {
  const Manifest head = volumeOf(VoxelType::u16, 0, 2560, {{5, 600000}, {500, 390000}, {1500, 6000}, {2500, 4000}});
  const TransferFunction f = presetFor("mr-angio", head);
  for (const double value : {5.0, 500.0}) EXPECT_FALSE(f.interesting(value)) << value;
  EXPECT_GT(f.at(1500).opacity, 0.1);
  EXPECT_GT(f.at(2559).opacity, 0.4);
}

TEST(Presets, MrBrain_isSolidAboveFluid) {
  const Manifest brain = volumeOf(VoxelType::u16, 0, 2560, {{5, 700000}, {800, 150000}, {1400, 150000}});
  const TransferFunction f = presetFor("mr-brain", brain);
  EXPECT_FALSE(f.interesting(100));
  EXPECT_GT(f.at(800).opacity, 0.7);
  EXPECT_GT(f.at(1400).color.g, f.at(800).color.g);  // white matter
}

// Bone is solid, skin is translucent, and values between them are transparent.
TEST(Presets, BoneShowsThroughTranslucentSkin) {
  const TransferFunction f = presetFor("ct-bone-and-skin", ctHead(0, VoxelType::i16));
  EXPECT_FALSE(f.interesting(-900));
  EXPECT_GT(f.at(-300).opacity, 0.01);
  EXPECT_LT(f.at(-300).opacity, 0.2);
  EXPECT_FALSE(f.interesting(50));
  EXPECT_GT(f.at(500).opacity, 0.8);
}

TEST(Presets, ASolidBeginsAtItsValue) {
  const Manifest head = ctHead(0, VoxelType::i16);
  const TransferFunction f = presetFor("solid:-312.5", head);
  EXPECT_FALSE(f.interesting(-330));
  EXPECT_NEAR(f.at(-312.5).opacity, 0.5 * 0.97, 1e-12);
  EXPECT_EQ(f.at(2000).opacity, 0.97);
  for (const char* wrong : {"solid:", "solid:bone", "solid:3x", "solid:nan", "solid:1e999", "solid:1,2"})
    EXPECT_THROW(presetFor(wrong, head), Error) << wrong;
  EXPECT_TRUE(isPreset("solid:3"));
  EXPECT_FALSE(isPreset("solid"));
}

TEST(Presets, IsoSurfacesHaveValuesOpacitiesAndColours) {
  const Manifest head = ctHead(0, VoxelType::i16);
  const TransferFunction f = presetFor("iso:-312.5:0.25:#f00,300,1200:1:white", head);
  ASSERT_EQ(f.surfaces.size(), 3u);
  EXPECT_TRUE(f.points.empty());
  EXPECT_EQ(f.surfaces[0].value, -312.5);
  EXPECT_EQ(f.surfaces[0].opacity, 0.25);
  EXPECT_EQ(f.surfaces[0].color, glm::dvec3(1, 0, 0));
  EXPECT_EQ(f.surfaces[1].opacity, 1);
  EXPECT_EQ(f.surfaces[1].color, IsoSurface().color);
  EXPECT_EQ(f.surfaces[2].color, glm::dvec3(1));
  EXPECT_TRUE(isPreset("iso:3"));
  EXPECT_FALSE(isPreset("iso"));
}

TEST(Presets, WrongIsoSurfaces_areRefused) {
  const Manifest head = ctHead(0, VoxelType::i16);
  for (const char* wrong : {"iso:", "iso:bone", "iso:3x", "iso:nan", "iso:1e999", "iso:3:", "iso:3:2", "iso:3:-1",
                            "iso:3:1:no", "iso:3:1:red:1", "iso:3,", "iso:3,2", "iso:3,3"})
    EXPECT_THROW(presetFor(wrong, head), Error) << wrong;
  std::string many = "iso:0";
  for (int i = 1; i <= 32; ++i) many += "," + std::to_string(i);
  EXPECT_THROW(presetFor(many, head), Error);
  EXPECT_EQ(presetFor(many.substr(0, many.rfind(',')), head).surfaces.size(), 32u);
}

// 8 bits from air to dense bone: equal positions within the range.
TEST(Presets, CtWithoutAKnownScaleIsProportional) {
  const Manifest engine = volumeOf(VoxelType::u8, 0, 255, {{5, 700}, {120, 300}});
  EXPECT_NEAR(presetFor("ct-skin", engine).points.front().value, 474 * 255 / 3272.0, 1);
}

TEST(Presets, AutoDrawsTheSurfaceBetweenAirAndTissue) {
  for (const double shift : {0.0, 1024.0}) {
    const TransferFunction f = presetFor("auto", ctHead(shift, VoxelType::i16));
    EXPECT_FALSE(f.interesting(shift - 900));
    EXPECT_GT(f.at(shift + 50).opacity, 0.8);
  }
  // A magnetic resonance head: noise, skin and grey matter, a bright rest.
  const Manifest mr = volumeOf(VoxelType::u16, 1026, 5119, {{1080, 800}, {1900, 150}, {2300, 50}});
  for (const char* name : {"auto", "mr-head"}) {
    EXPECT_FALSE(presetFor(name, mr).interesting(1090)) << name;
    EXPECT_GT(presetFor(name, mr).at(1900).opacity, 0.8) << name;
  }
  EXPECT_LT(presetFor("mr-head", mr).points.front().value, presetFor("auto", mr).points.front().value);
}

// A background of exact zeros that fills nearly everything; then a few very bright voxels that would attract the
// threshold.
TEST(Presets, AutoIsNotTakenInByDominantPeaks) {
  const Manifest masked = volumeOf(VoxelType::u8, 0, 255, {{0, 950000}, {100, 49000}, {255, 1000}});
  EXPECT_GT(presetFor("auto", masked).at(110).opacity, 0.2);
  EXPECT_FALSE(presetFor("auto", masked).interesting(0));
  const Manifest metal = volumeOf(VoxelType::u16, 0, 60000, {{0, 700000}, {3000, 299000}, {60000, 1000}});
  EXPECT_LT(presetFor("auto", metal).points.front().value, 3000);
  EXPECT_GT(presetFor("auto", metal).points.front().value, 0);
}

// Along a box diagonal of 173 voxels a density at the upper end absorbs e^-6.
TEST(Presets, FogHasAnOpticalDepthOfSixAcrossTheBox) {
  Manifest cloud = volumeOf(VoxelType::f32, 0, 4, {{0, 900000}, {1, 90000}, {3.99, 10000}});
  cloud.volume_class = VolumeClass::kFog;
  const TransferFunction f = presetFor("auto", cloud);
  EXPECT_FALSE(f.interesting(0));
  EXPECT_NEAR(extinctionOf(f.at(4).opacity, 1) * 100 * std::sqrt(3.0), 6, 1e-9);
}

// Known because values have no absolute unit: scaling values by 1e-18 scales the function.
TEST(Presets, SmallValuesHaveTheirOwnSurface) {
  const auto scaled = [](double s) {
    return volumeOf(VoxelType::f32, 0, 4 * s, {{0.1 * s, 700}, {3 * s, 250}, {3.99 * s, 50}});
  };
  for (const char* name : {"auto", "mr-head"}) {
    const TransferFunction usual = presetFor(name, scaled(1));
    for (const double scale : {1e-18, 1e-300, 1e18}) {
      const TransferFunction f = presetFor(name, scaled(scale));
      ASSERT_EQ(f.points.size(), usual.points.size());
      for (std::size_t i = 0; i < f.points.size(); ++i)
        EXPECT_NEAR(f.points[i].value / scale, usual.points[i].value, 1e-12) << name << ' ' << scale;
    }
  }
}

TEST(Presets, LevelSetIsItsZeroSurface) {
  Manifest ball = volumeOf(VoxelType::f32, -0.3, 0.3, {{-0.3, 10}, {0.3, 10}});
  ball.volume_class = VolumeClass::kLevelSet;
  for (int axis = 0; axis < 3; ++axis) ball.levels[0].geometry.world_from_index[axis][axis] = 0.1;
  const TransferFunction f = presetFor("auto", ball);
  EXPECT_EQ(f.at(-0.2).opacity, 1);
  EXPECT_EQ(f.at(0).opacity, 1);
  EXPECT_NEAR(f.at(0.025).opacity, 0.5, 1e-12);
  EXPECT_EQ(f.at(0.051).opacity, 0);
}

TEST(Presets, ConstantAndEmptyVolumesHaveAFunctionToo) {
  std::vector<Manifest> volumes = {volumeOf(VoxelType::u8, 7, 7, {{7, 1000}}),
                                   volumeOf(VoxelType::u8, 0, 0, {{0, 1000}}), volumeOf(VoxelType::f32, 0, 1, {})};
  volumes.push_back(volumes[0]);
  volumes.back().histogram = {};
  volumes.push_back(volumes[0]);
  volumes.back().range = {};  // only NaN
  volumes.back().histogram = {};
  for (const double huge : {1e30, 1e300})
    volumes.push_back(volumeOf(VoxelType::f64, -huge, huge, {{0, 10}, {huge, 4}}));
  for (const Manifest& volume : volumes) {
    for (const VolumeClass kind : {VolumeClass::kUnknown, VolumeClass::kFog, VolumeClass::kLevelSet}) {
      Manifest manifest = volume;
      manifest.volume_class = kind;
      for (const std::string& name : presetNames()) {
        const TransferFunction f = presetFor(name, manifest);
        ASSERT_FALSE(f.points.empty());
        for (std::size_t i = 0; i < f.points.size(); ++i) {
          EXPECT_TRUE(std::isfinite(f.points[i].value)) << name;
          EXPECT_TRUE(f.points[i].opacity >= 0 && f.points[i].opacity <= 1) << name;
          EXPECT_LE(f.points[i > 0 ? i - 1 : 0].value, f.points[i].value) << name;
        }
      }
    }
  }
}

// Known because viewers show the begin of a window black and its end in the colour, and nothing below the begin.
TEST(Presets, WindowOfTheSource_isTheDefault) {
  Manifest head = ctHead(0, VoxelType::i16);
  head.look.ramp = DeclaredLook::Ramp{100, 700, {255, 0, 255, 255}};
  for (const TransferFunction& f : {presetFor("auto", head), displayRamp(head, usableRange(head))}) {
    EXPECT_EQ(f.points.front().value, 100);
    EXPECT_EQ(f.points.back().value, 700);
    EXPECT_EQ(f.at(100).color, glm::dvec3(0));
    EXPECT_EQ(f.at(900).color, glm::dvec3(1, 0, 1));
  }
  EXPECT_EQ(presetFor("auto", head).at(100).opacity, 0);
  EXPECT_GT(presetFor("auto", head).at(700).opacity, presetFor("auto", head).at(400).opacity);
  EXPECT_EQ(displayRamp(head, usableRange(head)).at(0).opacity, 1);
  EXPECT_EQ(presetFor("ct-skin", head).points.size(), presetFor("ct-skin", ctHead(0, VoxelType::i16)).points.size());
  head.volume_class = VolumeClass::kFog;
  EXPECT_NE(presetFor("auto", head).points.back().value, 700) << "a fog is drawn as fog";
}

}  // namespace
}  // namespace kiln
