// Frames and units of volumes in a picture. Known because RAS and LPS differ in two signs, and the lengths of units are
// defined.
#include "grid/shared_world.h"

#include <gtest/gtest.h>

#include "scene/transfer/transfer_function.h"
#include "store/manifest/manifest.h"

namespace kiln::test {
namespace {

VolumeGeometry volumeIn(PatientFrame frame, const std::string& unit) {
  VolumeGeometry out;
  out.dims = {4, 5, 6};
  out.world_from_index = {{0.7, 0.1, 0, 0}, {0, 0.9, 0.2, 0}, {0, 0, 2.1, 0}, {-100, 50, 20, 1}};
  out.frame = frame;
  out.unit = unit;
  return out;
}

TEST(SharedWorld, Units_areQuotientsOfWholeNumbers) {
  EXPECT_EQ(lengthRatio("mm", "mm"), LengthRatio());
  EXPECT_EQ(lengthRatio("furlong", "furlong"), LengthRatio());
  EXPECT_EQ(lengthRatio("mm", "um"), (LengthRatio{1000, 1}));
  EXPECT_EQ(lengthRatio("um", "mm"), (LengthRatio{1, 1000}));
  EXPECT_EQ(lengthRatio("\u00b5m", "micron"), (LengthRatio{1, 1}));
  EXPECT_EQ(lengthRatio("in", "cm"), (LengthRatio{127, 50}));
  EXPECT_EQ(lengthRatio("m", "km"), (LengthRatio{1, 1000}));
  EXPECT_FALSE(lengthRatio("furlong", "mm"));
  EXPECT_FALSE(lengthRatio("", "mm"));
}

TEST(SharedWorld, EqualWorlds_changeNoBit) {
  const VolumeGeometry lps = volumeIn(PatientFrame::kLps, "mm");
  EXPECT_TRUE(worldChange(lps, lps).none());
  EXPECT_TRUE(worldChange(volumeIn(PatientFrame::kUnknown, ""), lps).none());
  EXPECT_EQ(worldChange(lps, lps).of(lps.world_from_index), lps.world_from_index);
}

TEST(SharedWorld, OtherFrame_changesTwoSigns) {
  const VolumeGeometry lps = volumeIn(PatientFrame::kLps, "mm"), ras = volumeIn(PatientFrame::kRas, "mm");
  const WorldChange change = worldChange(ras, lps);
  const glm::dmat4 turned = change.of(ras.world_from_index);
  for (int column = 0; column < 4; ++column) {
    EXPECT_EQ(turned[column].x, -ras.world_from_index[column].x);
    EXPECT_EQ(turned[column].y, -ras.world_from_index[column].y);
    EXPECT_EQ(turned[column].z, ras.world_from_index[column].z);
    EXPECT_EQ(turned[column].w, ras.world_from_index[column].w);
  }
}

TEST(SharedWorld, FirstKnownFrameAndUnit_areTheWorlds) {
  const VolumeGeometry world = sharedWorld(
      {volumeIn(PatientFrame::kUnknown, "um"), volumeIn(PatientFrame::kRas, "mm"), volumeIn(PatientFrame::kLps, "cm")});
  EXPECT_EQ(world.frame, PatientFrame::kRas);
  EXPECT_EQ(world.unit, "um");
}

TEST(SharedWorld, UnknownFrameOrUnit_isSaid) {
  const VolumeGeometry world = volumeIn(PatientFrame::kLps, "mm");
  EXPECT_EQ(assumptionText(world, world), "");
  EXPECT_EQ(assumptionText(volumeIn(PatientFrame::kRas, "um"), world), "");
  EXPECT_NE(assumptionText(volumeIn(PatientFrame::kUnknown, "mm"), world).find("frame were LPS"), std::string::npos);
  EXPECT_NE(assumptionText(volumeIn(PatientFrame::kLps, ""), world).find("taken as 'mm'"), std::string::npos);
  EXPECT_NE(assumptionText(volumeIn(PatientFrame::kLps, "furlong"), world).find("'furlong'"), std::string::npos);
  const VolumeGeometry nothing_known = volumeIn(PatientFrame::kUnknown, "");
  EXPECT_EQ(assumptionText(nothing_known, nothing_known), "");
}

// A body's optical depth depends on no unit of length.
TEST(SharedWorld, OpacityIsPerLengthOfTheVolumesOwnUnit) {
  Manifest manifest;
  manifest.levels.push_back({volumeIn(PatientFrame::kLps, "um"), {1, 1, 1}, 0, 0});
  const double own = manifest.ownMeanSpacing();
  manifest.placeIn(volumeIn(PatientFrame::kLps, "mm"));
  EXPECT_DOUBLE_EQ(manifest.geometry().meanSpacing(), own / 1000);
  EXPECT_DOUBLE_EQ(manifest.ownMeanSpacing(), own);
  TransferFunction function{2, {{0, glm::dvec3(1), 0.5}}};
  function.gradient_opacity = {{3, 1}};
  const TransferFunction placed = inWorld(function, manifest.world_per_own);
  EXPECT_DOUBLE_EQ(extinctionOf(0.5, placed.unit) * manifest.geometry().meanSpacing(), extinctionOf(0.5, 2) * own);
  EXPECT_DOUBLE_EQ(placed.gradient_opacity[0].gradient, 3000);
}

}  // namespace
}  // namespace kiln::test
