// The place of a volume by the user's words. Known because each letter is a direction of the patient. The voxels of a
// mirrored volume lie at the places of their mirror images.
#include "ingest/source/placement.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "grid/coords.h"
#include "ingest/open_source.h"
#include "support/files/foreign_files.h"
#include "support/files/vdb_files.h"

namespace kiln::test {
namespace {

VolumeGeometry upright() {
  VolumeGeometry out;
  out.dims = {4, 5, 6};
  out.world_from_index[0].x = 1, out.world_from_index[1].y = 2, out.world_from_index[2].z = 3;
  out.world_from_index[3] = {10, 20, 30, 1};
  return out;
}

Placement byLetters(const char* letters) {
  Placement out;
  out.axes = axisLettersOf(letters);
  return out;
}

TEST(Placement, LettersNameTheDirectionsOfVoxelAxes) {
  const VolumeGeometry lps = placed(upright(), byLetters("LPS"), "f");
  EXPECT_EQ(lps.frame, PatientFrame::kRas);
  EXPECT_EQ(lps.world_from_index, glm::dmat4(glm::dvec4(-1, 0, 0, 0), glm::dvec4(0, -2, 0, 0), glm::dvec4(0, 0, 3, 0),
                                             glm::dvec4(10, 20, 30, 1)));
  const VolumeGeometry sra = placed(upright(), byLetters("sra"), "f");
  EXPECT_EQ(sra.world_from_index, glm::dmat4(glm::dvec4(0, 0, 1, 0), glm::dvec4(2, 0, 0, 0), glm::dvec4(0, 3, 0, 0),
                                             glm::dvec4(10, 20, 30, 1)));
  EXPECT_EQ(placed(upright(), byLetters("RAS"), "f").world_from_index, upright().world_from_index);
}

TEST(Placement, ThereAre48Orientations) {
  const std::string letters = "RLAPSI";
  int known = 0;
  for (const char a : letters)
    for (const char b : letters)
      for (const char c : letters) known += axisLettersOf(std::string{a, b, c}) ? 1 : 0;
  EXPECT_EQ(known, 48);
  for (const char* wrong : {"", "R", "RA", "RASS", "RLS", "XYZ", "RRS"}) EXPECT_FALSE(axisLettersOf(wrong)) << wrong;
}

TEST(Placement, AMirroredVolumeKeepsItsBox) {
  Placement placement;
  placement.flip = {true, false, true};
  const VolumeGeometry before = upright(), after = placed(before, placement, "f");
  for (const VoxelCoord v : {VoxelCoord{0, 0, 0}, {3, 0, 0}, {1, 2, 3}, {3, 4, 5}})
    EXPECT_EQ(after.worldOf({v.x, v.y, v.z}), before.worldOf({3 - v.x, v.y, 5 - v.z}));
  EXPECT_EQ(after.dims, before.dims);
  EXPECT_EQ(after.frame, PatientFrame::kUnknown);
  EXPECT_EQ(placed(after, placement, "f").world_from_index, before.world_from_index);
}

TEST(Placement, AWorldWithYUpIsTurnedUpright) {
  Placement placement;
  placement.up = UpAxis::kY;
  const VolumeGeometry out = placed(upright(), placement, "f");
  EXPECT_EQ(out.worldOf({1, 1, 1}), glm::dvec3(11, -33, 22));
  EXPECT_EQ(out.voxelVolume(), 6);
}

TEST(Placement, WordsThatContradictTheFileAreRefused) {
  const auto refused = [](const VolumeGeometry& geometry, const Placement& placement, const std::string& part) {
    expectError([&] { placed(geometry, placement, "f"); }, ErrorCode::kUsage, part);
  };
  VolumeGeometry patient = upright(), turned = upright();
  patient.frame = PatientFrame::kLps;
  turned.world_from_index[0].y = 0.1;
  Placement y_up, both = byLetters("RAS");
  y_up.up = both.up = UpAxis::kY;
  refused(patient, byLetters("RAS"), "--orient: is for files without directions");
  refused(turned, byLetters("RAS"), "found a rotated or mirrored affine");
  refused(patient, y_up, "--up-axis: is for files without a patient frame");
  refused(upright(), both, "leave one out");
  VolumeGeometry of_mm = upright();
  of_mm.unit = "mm";
  Placement um;
  um.unit = "um";
  refused(of_mm, um, "--unit: is for files that state no unit of length (found mm)");
  of_mm.unit = "\u00B5m";  // as ImageJ writes it
  EXPECT_EQ(placed(of_mm, um, "f").unit, "um");
  EXPECT_EQ(placed(upright(), um, "f").unit, "um");
}

// An export restores the grid's own coordinates: both affines of a placed grid lead to one place.
TEST(Placement, OfAGridHoldsForItsOwnCoordinates) {
  const ForeignFiles files;
  writeVdb(files.directory() / "g.vdb", {VdbSpec{}});
  SourceOptions options;
  options.placement.flip = {true, true, false};
  options.placement.up = UpAxis::kY;
  const SourceInfo info = openSource(files.directory() / "g.vdb", options)->info();
  ASSERT_TRUE(info.vdb);
  EXPECT_EQ(info.vdb->index_origin, kVdbOrigin);
  for (const glm::dvec3 v : {glm::dvec3(0), glm::dvec3(12, 8, 10), glm::dvec3(3, 1, 4)}) {
    const glm::dvec4 in_grid(v.x + kVdbOrigin.x, v.y + kVdbOrigin.y, v.z + kVdbOrigin.z, 1);
    EXPECT_EQ(glm::dvec3(info.vdb->world_from_grid * in_grid), info.geometry.worldOf(v));
  }
}

}  // namespace
}  // namespace kiln::test
