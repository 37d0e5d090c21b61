// Spacings of TIFF files from tags, and of ImageJ's stacks from their more detailed description. Known because the tags
// are written here.
#include <gtest/gtest.h>

#include "ingest/open_source.h"
#include "support/volumes/tiff_files.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

glm::dvec3 spacingOf(const fs::path& path, const SourceOptions& options = {}) {
  return openSource(path, options)->info().geometry.spacing();
}

TEST(IngestTiff, SpacingIsWhatTheFilesSayWhereTheySayIt) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kStackDims, VoxelType::u8, 18);
  const fs::path path = files.directory() / "a.tif";
  const auto write = [&](double x, double y, int unit, const std::string& description = "") {
    TiffLayout layout;
    layout.x_resolution = x, layout.y_resolution = y, layout.resolution_unit = unit, layout.description = description;
    writeTiff(path, volume, 0, kStackDims.z, layout);
  };
  write(0, 0, 0);
  EXPECT_EQ(spacingOf(path), glm::dvec3(1));
  for (const double printer : {72.0, 96.0, 300.0}) {
    write(printer, printer, 2);
    EXPECT_EQ(spacingOf(path), glm::dvec3(1)) << printer;
    write(printer / 2.54, printer / 2.54, 3);
    EXPECT_EQ(spacingOf(path), glm::dvec3(1)) << printer;
  }
  write(500, 500, 1);  // no unit
  EXPECT_EQ(spacingOf(path), glm::dvec3(1));
  write(500, 250, 3);  // 0.02 and 0.04 mm
  EXPECT_NEAR(spacingOf(path).x, 0.02, 1e-9);
  EXPECT_NEAR(spacingOf(path).y, 0.04, 1e-9);
  EXPECT_NEAR(spacingOf(path).z, 0.02, 1e-9);
  EXPECT_EQ(openSource(path)->info().geometry.unit, "mm");
  EXPECT_EQ(openSource(path)->info().notes.size(), 1u);
  SourceOptions options;
  options.spacing = glm::dvec3(1, 2, 3);
  EXPECT_EQ(spacingOf(path, options), glm::dvec3(1, 2, 3));
  EXPECT_EQ(openSource(path, options)->info().notes.size(), 0u);
  write(4, 2, 1, "ImageJ=1.53c\nimages=4\nslices=4\nunit=\\u00B5m\nspacing=1.5\nloop=false\n");
  EXPECT_EQ(spacingOf(path), glm::dvec3(0.25, 0.5, 1.5));
  EXPECT_EQ(openSource(path)->info().geometry.unit, "um");
  write(0, 0, 0, "ImageJ=1.53c\nimages=4\nslices=4\nspacing=2.0\n");
  EXPECT_EQ(spacingOf(path), glm::dvec3(1, 1, 2));
  write(0, 0, 0, "ImageJ=\nspacing=nan\nunit=mm\nimages=x\n=\n\n");
  EXPECT_EQ(spacingOf(path), glm::dvec3(1));
}

struct SaidUnits {
  std::string description;
  glm::dvec3 spacing;
  std::string unit;
  /// Part of the first note; empty for none.
  std::string note;
};

void expectUnits(const SaidUnits& said) {
  SCOPED_TRACE(said.description);
  const ForeignFiles files;
  TiffLayout layout;
  layout.description = said.description;
  layout.x_resolution = layout.y_resolution = 2, layout.resolution_unit = 1;
  writeTiff(files.directory() / "a.tif", randomVolume(kStackDims, VoxelType::u8, 18), 0, 4, layout);
  const SourceInfo info = openSource(files.directory() / "a.tif")->info();
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(info.geometry.spacing()[axis], said.spacing[axis], 1e-12 * said.spacing[axis]) << axis;
  EXPECT_EQ(info.geometry.unit, said.unit);
  ASSERT_EQ(info.notes.size(), said.note.empty() ? 0u : 1u);
  if (!said.note.empty()) {
    EXPECT_NE(info.notes.front().find(said.note), std::string::npos) << info.notes.front();
  }
}

TEST(IngestTiff, ImageJUnitsOfAxes_AreConvertedToTheUnitOfX) {
  const std::string stack = "ImageJ=1.54f\nimages=4\nslices=4\nloop=false\n";
  for (const SaidUnits& said : {
           SaidUnits{stack + "unit=um\nspacing=2.0\n", {0.5, 0.5, 2}, "um", ""},
           {stack + "unit=um\n", {0.5, 0.5, 1}, "um", ""},  // ImageJ leaves a spacing of 1 out
           {stack + "unit=um\nspacing=1500\nzunit=nm\n", {0.5, 0.5, 1.5}, "um", ""},
           {stack + "unit=um\nzunit=nm\n", {0.5, 0.5, 0.001}, "um", ""},
           {stack + "unit=um\nspacing=2\nyunit=mm\n", {0.5, 500, 2}, "um", ""},
           {stack + "unit=inch\nspacing=2\n", {0.5, 0.5, 2}, "in", ""},
           {stack + "unit=micron\nspacing=-0.5\n", {0.5, 0.5, 0.5}, "um", ""},
           {stack + "spacing=3\n", {1, 1, 3}, "", ""},
           {stack + "unit=pixel\nspacing=3\n", {1, 1, 3}, "", ""},
           {stack + "unit=furlong\nspacing=3\n", {0.5, 0.5, 3}, "", "'furlong', which is no known unit"},
           {stack + "unit=um\nspacing=3\nyunit=furlong\n", {0.5, 0.5, 3}, "um", "along y in 'furlong' and along x in"},
           // A single image has no slice distance that ImageJ would write.
           {"ImageJ=1.54f\nunit=um\n", {0.5, 0.5, 0.5}, "um", "no distance of slices"},
       })
    expectUnits(said);
}

TEST(IngestTiff, OmeUnitsOfAxes_AreConvertedToTheUnitOfX) {
  const auto pixels = [](const std::string& x, const std::string& x_unit, const std::string& z,
                         const std::string& z_unit) {
    const auto length = [](const std::string& axis, const std::string& number, const std::string& unit) {
      return " PhysicalSize" + axis + "='" + number + "'" +
             (unit.empty() ? "" : " PhysicalSize" + axis + "Unit='" + unit + "'");
    };
    return "<OME x='y'><Image><Pixels SizeC='1' SizeT='1' SizeZ='4'" + length("X", x, x_unit) + length("Y", x, x_unit) +
           (z.empty() ? "" : length("Z", z, z_unit)) + "/></Image></OME>";
  };
  const std::string um = "\xc2\xb5m";
  for (const SaidUnits& said : {
           SaidUnits{pixels("0.5", um, "1.5", um), {0.5, 0.5, 1.5}, "um", ""},
           {pixels("0.5", um, "1500", "nm"), {0.5, 0.5, 1.5}, "um", ""},
           {pixels("0.3", um, "1e-5", "dm"), {0.3, 0.3, 1}, "um", ""},
           {pixels("0.5", "", "0.0015", "mm"), {0.5, 0.5, 1.5}, "um", ""},
           {pixels("500", "nm", "1.5", um), {500, 500, 1500}, "nm", ""},
           {pixels("0.5", "&#181;m", "1.5", "&#xB5;m"), {0.5, 0.5, 1.5}, "um", ""},
           {pixels("13.48", "\xc3\x85", "26.96", "\xc3\x85"), {13.48, 13.48, 26.96}, "angstrom", ""},
           {pixels("500", "pm", "1500", "pm"), {500, 500, 1500}, "pm", ""},
           {pixels("0.5", um, "", ""), {0.5, 0.5, 0.5}, "um", "OME's description has 0.5 um a pixel and no distance"},
           {pixels("1", "reference frame", "3", "reference frame"), {1, 1, 3}, "", "'reference frame', which is no"},
       })
    expectUnits(said);
  const ForeignFiles files;
  TiffLayout layout;
  layout.description = pixels("0.5", um, "3", "parsec");
  writeTiff(files.directory() / "a.tif", randomVolume(kStackDims, VoxelType::u8, 18), 0, 4, layout);
  const auto source = openSource(files.directory() / "a.tif");
  EXPECT_EQ(source->info().geometry.spacing(), glm::dvec3(0.5));
  ASSERT_EQ(source->info().notes.size(), 2u);
  EXPECT_NE(source->info().notes[0].find("along z in 'parsec'"), std::string::npos) << source->info().notes[0];
}

// As ImageJ writes stacks of more than 4 GB: a single directory, big-endian, and the images concatenated.
TEST(IngestTiff, ImagesBehindImageJsOnlyDirectoryAreSlices) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({21, 19, 5}, VoxelType::u16, 19);
  TiffLayout layout;
  layout.big_endian = true;
  layout.description = "ImageJ=1.53c\nimages=5\nslices=5\n";
  writeTiff(files.directory() / "a.tif", volume, 0, 1, layout);
  std::string bytes = bytesOf(files.directory() / "a.tif");
  const std::string page = volume.stored(true).substr(0, 21 * 19 * 2);
  const std::size_t strip = bytes.find(page);
  ASSERT_NE(strip, std::string::npos);
  // The strip's offset, a long in entry 273, points to the end, where all five images are.
  const std::string entry("\x01\x11\x00\x04\x00\x00\x00\x01", 8);
  const std::size_t at = bytes.find(entry);
  ASSERT_NE(at, std::string::npos);
  for (int i = 0; i < 4; ++i)
    bytes[at + 8 + static_cast<std::size_t>(i)] = static_cast<char>(bytes.size() >> (24 - 8 * i));
  bytes += volume.stored(true);
  files.write("a.tif", bytes);
  expectReadsBack(
      volume, [&] { return openSource(files.directory() / "a.tif"); }, 19);
  bytes.pop_back();
  files.write("a.tif", bytes);
  expectRefused(files.directory() / "a.tif", ErrorCode::kFormat, "5 images, but the file ends after 4");
}

}  // namespace
}  // namespace kiln::test
