// What TIFF files say beside their pixels: how far apart these are, and ImageJ's stacks, whose description says more
// than the tags. Answers are known because the tags were written here.
#include <gtest/gtest.h>

#include "support/tiff_files.h"

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

// As ImageJ writes stacks of more than 4 GB: one directory, big-endian, and the images one behind the other.
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
  // The strip's offset, a long in entry 273, points to the end, where all five are.
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
