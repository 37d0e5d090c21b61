// Spacings of TIFF files from tags, and of ImageJ's stacks from their more detailed description. Known because the tags
// are written here.
#include "ingest/tiff/tiff_spacing.h"

#include <gtest/gtest.h>

#include "ingest/open_source.h"
#include "support/files/tiff_files.h"

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

TEST(IngestTiff, TifffilesSpacingAndUnit_MeanWhatTheyMeanInImageJ) {
  const std::string shape = R"({"shape": [4, 19, 21], )";
  for (const SaidUnits& said : {
           SaidUnits{shape + R"("axes": "ZYX", "spacing": 1.5, "unit": "um"})", {0.5, 0.5, 1.5}, "um", ""},
           {shape + R"("spacing": 1.5, "unit": "\u00b5m"})", {0.5, 0.5, 1.5}, "um", ""},
           {shape + R"("unit": "mm", "spacing": [1.5, 0.25, 0.75]})", {0.75, 0.25, 1.5}, "mm", ""},
           {R"({"axes": "ZYX", "spacing": 1.5, "unit": "um", "shape": [4, 19, 21]})", {0.5, 0.5, 1.5}, "um", ""},
           {shape + R"("spacing": 3})", {1, 1, 3}, "", ""},
           {shape + R"("unit": "nm"})", {0.5, 0.5, 0.5}, "nm", "tifffile's description has 0.5 nm a pixel and no"},
           {shape + R"("unit": "furlong", "spacing": 3})", {0.5, 0.5, 3}, "", "'furlong', which is no known unit"},
           {shape + R"("comment": "a \"spacing\": 7"})", {1, 1, 1}, "", "no size of a voxel, which is taken to be 1"},
       })
    expectUnits(said);
  // Tags with a unit of their own: 5000 pixels a centimetre are 2 um each.
  const ForeignFiles files;
  TiffLayout layout;
  layout.description = shape + R"("spacing": 3.5, "unit": "um"})";
  layout.x_resolution = layout.y_resolution = 5000, layout.resolution_unit = 3;
  writeTiff(files.directory() / "a.tif", randomVolume(kStackDims, VoxelType::u8, 18), 0, 4, layout);
  EXPECT_NEAR(spacingOf(files.directory() / "a.tif").x, 2, 1e-12);
  EXPECT_EQ(spacingOf(files.directory() / "a.tif").z, 3.5);
}

constexpr const char* kLog =
    "[System]\r\nScanner=SkyScan1172\r\n[Acquisition]\r\nImage Pixel Size (um)=    9.92\r\nPixel Size (um)=7\r\n"
    "[Reconstruction]\r\nSection to Section Step=1\r\nResult Image Width (pixels)=21\r\n"
    "Result Image Height (pixels)=19\r\nPixel Size (um)=4.5\r\n[File name convention]\r\nPixel Size (um)=6\r\n";

// A folder of slices with logs beside them.
class LoggedSlices {
 public:
  void slice(const std::string& name, const TiffLayout& layout = {}) const {
    writeTiff(files_.directory() / name, randomVolume(kStackDims, VoxelType::u8, 18), 0, 1, layout);
  }
  void log(const std::string& name, const std::string& text) const { files_.write(name, text); }
  glm::dvec3 spacing() const { return spacingOf(files_.directory()); }
  SourceInfo info() const { return openSource(files_.directory())->info(); }
  std::string notes() const {
    std::string out;
    for (const std::string& note : info().notes) out += note + "\n";
    return out;
  }

 private:
  ForeignFiles files_;
};

// Known from tifffile: the samples of a colour are the last dimension.
TEST(IngestTiff, SamplesInTifffilesShape_areNoChannels) {
  for (const char* const description :
       {R"({"shape": [6, 20, 30, 3]})", R"({"shape": [6, 20, 30, 3], "axes": "ZYXS"})"}) {
    const std::optional<StackNotes> notes = stackNotes(description, 3);
    ASSERT_TRUE(notes);
    EXPECT_EQ(notes->channels, 1);
    EXPECT_EQ(notes->frames, 1);
  }
  EXPECT_EQ(stackNotes(R"({"shape": [6, 20, 30, 3]})", 1)->channels, 6);
}

TEST(IngestTiff, ALogOfSkyScanStatesTheSpacing) {
  const LoggedSlices rat;
  TiffLayout layout;
  layout.x_resolution = layout.y_resolution = 500, layout.resolution_unit = 3;
  for (const char* name : {"rat__rec001.tif", "rat__rec002.tif"}) rat.slice(name, layout);
  rat.log("rat__rec.log", kLog);
  rat.log("rat_.log", "[Acquisition]\nImage Pixel Size (um)=8\n");
  EXPECT_EQ(rat.spacing(), glm::dvec3(4.5));
  EXPECT_EQ(rat.info().geometry.unit, "um");
  EXPECT_EQ(rat.info().files.back().filename(), "rat__rec.log");
  EXPECT_NE(rat.notes().find("is by the log 'rat__rec.log'"), std::string::npos) << rat.notes();
  EXPECT_NE(rat.notes().find("passed over 'rat_.log', which states no size"), std::string::npos) << rat.notes();
  // A log of another name counts if no log has the slices' name.
  rat.log("other.log", replaced(kLog, "=4.5", "=3"));
  EXPECT_EQ(rat.spacing(), glm::dvec3(4.5));
  rat.log("rat__rec.log", "no log");
  EXPECT_EQ(rat.spacing(), glm::dvec3(3));
  rat.log("third.log", kLog);
  EXPECT_NEAR(rat.spacing().x, 0.02, 1e-9) << "by the tags";
  EXPECT_NE(rat.notes().find("state different sizes of a voxel, of which none is taken"), std::string::npos);
}

TEST(IngestTiff, SlicesFurtherApartThanTheLogStates_AreByTheirNumbers) {
  const LoggedSlices every_third, by_log, cut;
  for (const char* name : {"r_rec003.tif", "r_rec006.tif"}) every_third.slice(name);
  every_third.log("r_rec.LOG", replaced(kLog, "Step=1", "Step=3"));
  EXPECT_EQ(every_third.spacing(), glm::dvec3(4.5, 4.5, 13.5));
  every_third.log("r_rec.LOG", kLog);
  EXPECT_EQ(every_third.spacing(), glm::dvec3(4.5, 4.5, 13.5));
  for (const char* name : {"r_rec1.tif", "r_rec2.tif"}) by_log.slice(name);
  by_log.log("r_rec.log", replaced(kLog, "Step=1", "Step=2"));
  EXPECT_EQ(by_log.spacing(), glm::dvec3(4.5, 4.5, 9));
  cut.slice("a1.tif");
  cut.log("a.log", replaced(kLog, "pixels)=21", "pixels)=42"));
  EXPECT_EQ(cut.spacing(), glm::dvec3(1));
  EXPECT_NE(cut.notes().find("passed over 'a.log', which is of slices of 42 x 19 pixels (found 21 x 19)"),
            std::string::npos)
      << cut.notes();
}

// As ImageJ writes stacks of more than 4 GB, and tifffile with truncate=True: a single directory, and the images
// concatenated. Known from tifffile 2023.2.3.
TEST(IngestTiff, ImagesBehindTheOnlyDirectoryAreSlices) {
  for (const auto& [writer, description] : {std::pair{"ImageJ", "ImageJ=1.53c\nimages=5\nslices=5\n"},
                                            {"tifffile", R"({"truncated": true, "shape": [5, 19, 21]})"}}) {
    SCOPED_TRACE(writer);
    const ForeignFiles files;
    const ForeignVolume volume = randomVolume({21, 19, 5}, VoxelType::u16, 19);
    TiffLayout layout;
    layout.big_endian = true;
    layout.description = description;
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
    SourceOptions little;
    little.memory_bytes = 100;
    expectRefused(files.directory() / "a.tif", ErrorCode::kBudget, "the table of 5 images takes", little);
    bytes.pop_back();
    files.write("a.tif", bytes);
    expectRefused(files.directory() / "a.tif", ErrorCode::kFormat,
                  std::string(writer) + "'s description says 5 images, but the file ends after 4");
  }
}

}  // namespace
}  // namespace kiln::test
