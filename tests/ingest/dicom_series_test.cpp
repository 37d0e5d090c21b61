// Selection of a volume's files in a directory, their order, and the volume's position. Known because the test writes
// the positions; the affine of a slice's corner is its position, to the last bit.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/error.h"
#include "ingest/open_source.h"
#include "support/files/dicom_files.h"
#include "support/files/foreign_files.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

// The first pixel of a slice stores the slice's number.
std::string slice(DicomSpec spec, int number) {
  spec.pixel_bytes = std::string(40, '\0');
  spec.pixel_bytes[0] = static_cast<char>(number);
  return dicomFile(spec);
}

std::string triple(const glm::dvec3& v) {
  return std::to_string(v.x) + "\\" + std::to_string(v.y) + "\\" + std::to_string(v.z);
}

class DicomSeries : public ::testing::Test {
 protected:
  // Writes slices a, b, c, … at these positions.
  void writeAt(const std::vector<glm::dvec3>& positions, DicomSpec spec = {}) {
    for (std::size_t i = 0; i < positions.size(); ++i) {
      spec.position = triple(positions[i]);
      files_.write(std::string(1, static_cast<char>('a' + i)), slice(spec, static_cast<int>(i)));
    }
  }
  std::unique_ptr<VolumeSource> open(const SourceOptions& options = {}) {
    return openSource(files_.directory(), options);
  }
  // The numbers of the slices in the order of the volume.
  std::vector<int> order(const SourceOptions& options = {}) {
    const auto source = open(options);
    std::vector<int> out;
    const std::vector<std::byte> bytes = readWhole(*source);
    const std::size_t slice_bytes = bytes.size() / static_cast<std::size_t>(source->info().geometry.dims.z);
    for (std::size_t at = 0; at < bytes.size(); at += slice_bytes) out.push_back(static_cast<int>(bytes[at]));
    return out;
  }
  void expectError(ErrorCode code, const std::string& says, const SourceOptions& options = {}) {
    expectRefused(files_.directory(), code, says, options);
  }
  static void expectNear(const glm::dvec3& a, const glm::dvec3& b) {
    EXPECT_LT(glm::length(a - b), 1e-9) << a.x << " " << a.y << " " << a.z;
  }
  ForeignFiles files_;
};

SourceOptions allowing() {
  SourceOptions out;
  out.allow_irregular = true;
  return out;
}

TEST_F(DicomSeries, PositionsOrderSlicesAndGiveTheAffine) {
  writeAt({{1, 2, 30}, {1, 2, 24}, {1, 2, 27}}, [] {
    DicomSpec spec;
    spec.spacing = "0.5\\0.25";  // distance of rows, then of columns
    return spec;
  }());
  EXPECT_EQ(order(), (std::vector{1, 2, 0}));
  const VolumeGeometry geometry = open()->info().geometry;
  EXPECT_EQ(geometry.frame, PatientFrame::kLps);
  EXPECT_EQ(geometry.unit, "mm");
  expectNear(geometry.worldOf({0, 0, 0}), {1, 2, 24});
  expectNear(geometry.worldOf({4, 2, 1}), {2, 3, 27});
  SourceOptions options;
  options.spacing = glm::dvec3(1);
  expectError(ErrorCode::kUsage, "--spacing", options);
}

// A coronal volume, rows down the patient: the normal points to the front, so slices go from back to front.
TEST_F(DicomSeries, TheNormalIsTheOrientationsOwn) {
  DicomSpec spec;
  spec.orientation = "1\\0\\0\\0\\0\\-1";
  writeAt({{-10, -5, 40}, {-10, -3, 40}, {-10, -1, 40}}, spec);
  // x cross -z is +y.
  EXPECT_EQ(order(), (std::vector{0, 1, 2}));
  expectNear(open()->info().geometry.worldOf({1, 2, 2}), {-9, -1, 38});
  spec.orientation = "-1\\0\\0\\0\\0\\-1";
  writeAt({{-10, -5, 40}, {-10, -3, 40}, {-10, -1, 40}}, spec);
  EXPECT_EQ(order(), (std::vector{2, 1, 0}));
  expectNear(open()->info().geometry.worldOf({1, 2, 2}), {-11, -5, 38});
}

TEST_F(DicomSeries, AMissingSliceIsNamedByItsNeighbours) {
  writeAt({{0, 0, 0}, {0, 0, 2}, {0, 0, 4}, {0, 0, 10}, {0, 0, 12}});
  expectError(ErrorCode::kFormat, "'c' and 'd' are 6 mm apart where others are 2 mm: 2 missing between them");
  expectError(ErrorCode::kFormat, "--allow-irregular");
  const auto source = open(allowing());
  expectNear(source->info().geometry.worldOf({0, 0, 4}), {0, 0, 8});
  ASSERT_EQ(source->info().notes.size(), 1u);
  EXPECT_NE(source->info().notes[0].find("'c' and 'd'"), std::string::npos);
}

TEST_F(DicomSeries, UnequalDistancesAreAnErrorAndRoundedOnesAreNot) {
  writeAt({{0, 0, 0}, {0, 0, 2}, {0, 0, 4}, {0, 0, 6.3}, {0, 0, 8.3}});
  expectError(ErrorCode::kFormat, "'c' and 'd' are 2.3 mm apart where others are 2 mm");
  expectNear(open(allowing())->info().geometry.worldOf({0, 0, 4}), {0, 0, 8});
  writeAt({{0, 0, 0}, {0, 0, 0.63}, {0, 0, 1.25}, {0, 0, 1.88}, {0, 0, 2.5}});
  expectNear(open()->info().geometry.worldOf({0, 0, 4}), {0, 0, 2.5});
}

// A gantry tilted by 20 degrees: slices are parallel and equally spaced, but each is shifted along its rows.
TEST_F(DicomSeries, GantryTiltIsAnErrorUntilItIsAllowedAndThenExactlyAShear) {
  const double angle = 20 * 3.14159265358979 / 180;
  DicomSpec spec;
  spec.orientation = "1\\0\\0\\0\\" + std::to_string(std::cos(angle)) + "\\" + std::to_string(std::sin(angle));
  writeAt({{0, 0, 0}, {0, 0, 5}, {0, 0, 10}}, spec);
  expectError(ErrorCode::kFormat, "'a' to 'c' are tilted by 20 degrees");
  const VolumeGeometry geometry = open(allowing())->info().geometry;
  expectNear(geometry.worldOf({0, 0, 2}), {0, 0, 10});
  EXPECT_NEAR(geometry.worldOf({0, 1, 0}).z, std::sin(angle), 1e-6);
}

TEST_F(DicomSeries, ASliceBesideTheOthersIsNamed) {
  writeAt({{0, 0, 0}, {0, 0, 2}, {0.5, 0, 4}, {0, 0, 6}, {0, 0, 8}});
  expectError(ErrorCode::kFormat, "'c' lies 0.5 mm beside the line");
  EXPECT_EQ(order(allowing()).size(), 5u);
}

TEST_F(DicomSeries, TwoSlicesAtOnePlaceAreSeveralVolumes) {
  writeAt({{0, 0, 0}, {0, 0, 2}, {0, 0, 2}, {0, 0, 4}});
  expectError(ErrorCode::kUnsupported, "'b' and 'c' lie at the same place");
  expectError(ErrorCode::kUnsupported, "'b' and 'c' lie at the same place", allowing());
}

TEST_F(DicomSeries, SlicesThatAreNotAlikeAreNamed) {
  writeAt({{0, 0, 0}, {0, 0, 2}});
  DicomSpec spec;
  spec.position = "0\\0\\4";
  DicomSpec other = spec;
  other.orientation = "0\\1\\0\\0\\0\\-1";
  files_.write("scout", slice(other, 9));
  expectError(ErrorCode::kFormat, "'scout' is turned against 'a'");
  other = spec, other.spacing = "1\\2";
  files_.write("scout", slice(other, 9));
  expectError(ErrorCode::kFormat, "'scout' has pixels of another size than 'a'");
  other = spec, other.position = "";
  files_.write("scout", slice(other, 9));
  expectError(ErrorCode::kFormat, "'scout' has no position");
  other = spec, other.is_signed = false;
  files_.write("scout", slice(other, 9));
  expectError(ErrorCode::kFormat, "scout: is 5 x 4 of u16");
  other = spec, other.orientation = "1\\0\\0\\1\\0\\0";
  files_.write("a", slice(other, 9)), files_.write("b", slice(other, 9)), files_.write("scout", slice(other, 9));
  expectError(ErrorCode::kFormat, "'a': the orientation is not two unit vectors");
}

// Known: all slices but one are equal, and the odd slice is named at every position.
TEST_F(DicomSeries, OddSlice_IsNamedBeItTheFirst) {
  const std::vector<glm::dvec3> positions = {{0, 0, 0}, {0, 0, 2}, {0, 0, 4}};
  DicomSpec turned, resized, unsigned_values, white;
  turned.orientation = "0\\1\\0\\0\\0\\-1";
  resized.spacing = "1\\2";
  unsigned_values.is_signed = false;
  white.photometric = "MONOCHROME1";
  const std::pair<DicomSpec, std::vector<std::string>> cases[] = {
      {turned, {"'a' is turned against 'b'", "'b' is turned against 'a'", "'c' is turned against 'a'"}},
      {resized,
       {"'a' has pixels of another size than 'b'", "'b' has pixels of another size than 'a'",
        "'c' has pixels of another size than 'a'"}},
      {unsigned_values,
       {"a: is 5 x 4 of u16, but 'b' is 5 x 4 of i16", "b: is 5 x 4 of u16, but 'a' is",
        "c: is 5 x 4 of u16, but 'a' is"}},
      {white,
       {"a: shows its smallest values white (MONOCHROME1), but 'b'", "b: shows its smallest values white",
        "c: shows its smallest values white"}}};
  for (const auto& [odd, expected] : cases) {
    for (std::size_t i = 0; i < 3; ++i) {
      writeAt(positions);
      DicomSpec spec = odd;
      spec.position = triple(positions[i]);
      files_.write(std::string(1, static_cast<char>('a' + i)), slice(spec, 0));
      expectError(ErrorCode::kFormat, expected[i]);
    }
  }
}

// Known: a slice without rescaling, beside slices with -1024, would be off by 1024.
TEST_F(DicomSeries, RescalingThatOneSliceLacks_IsAnError) {
  DicomSpec spec;
  spec.intercept = "-1024", spec.slope = "1";
  writeAt({{0, 0, 0}, {0, 0, 2}, {0, 0, 4}}, spec);
  EXPECT_TRUE(open()->info().notes.empty());
  DicomSpec lacking = spec;
  lacking.position = "0\\0\\2", lacking.intercept = "";
  files_.write("b", slice(lacking, 1));
  expectError(ErrorCode::kFormat,
              "b: has no RescaleIntercept (0028,1052), but 'a' has -1024; mend or remove it, or "
              "--allow-irregular takes 0 there");
  EXPECT_EQ(open(allowing())->info().notes,
            std::vector<std::string>{"'b' has no RescaleIntercept (0028,1052), but 'a' has -1024; took 0 there"});
  // An intercept of 0 is as good as none.
  spec.intercept = "0";
  writeAt({{0, 0, 0}, {0, 0, 2}, {0, 0, 4}}, spec);
  files_.write("b", slice(lacking, 1));
  EXPECT_TRUE(open()->info().notes.empty());
  spec.slope = "2";
  for (const char* none : {"", "0"}) {
    lacking.slope = none;
    writeAt({{0, 0, 0}, {0, 0, 2}, {0, 0, 4}}, spec);
    files_.write("b", slice(lacking, 1));
    expectError(ErrorCode::kFormat, "b: has no RescaleSlope (0028,1053), or one of 0, but 'a' has 2");
  }
}

// Known: exports have no file endings, and folders beside them are no slices; a pipe must be meant as a slice.
TEST_F(DicomSeries, PipeAmongSlicesWithoutEnding_IsAnError) {
  writeAt({{0, 0, 0}, {0, 0, 2}});
  fs::create_directory(files_.directory() / "notes");
  EXPECT_EQ(order(), (std::vector{0, 1}));
  ASSERT_EQ(::mkfifo((files_.directory() / "c").c_str(), 0600), 0);
  expectError(ErrorCode::kFormat, "c: is named like the slices beside it, but is a pipe or a device");
}

// Known: distances are positive; other values would mirror the volume.
TEST_F(DicomSeries, SpacingThatIsNotPositive_IsAnError) {
  for (const char* spacing : {"-1\\1", "1\\0"}) {
    DicomSpec spec;
    spec.spacing = spacing;
    writeAt({{0, 0, 0}, {0, 0, 2}}, spec);
    expectError(ErrorCode::kFormat, "(0028,0030): expected distances of pixels above 0 (found ");
  }
}

// Known: a file of another series moves no voxel, for every content of its header.
TEST_F(DicomSeries, FaultInAFileOfAnotherSeries_IsPassedOver) {
  writeAt({{0, 0, 0}, {0, 0, 2}});
  SourceOptions options;
  options.series = DicomSpec().series;
  DicomSpec other;
  other.series = "9.9", other.spacing = "0\\0";
  files_.write("z", slice(other, 5));
  EXPECT_EQ(order(options), (std::vector{0, 1}));
  other.spacing = "1\\1", other.slope = "1e300";
  files_.write("z", slice(other, 5));
  EXPECT_EQ(order(options), (std::vector{0, 1}));
  options.series = "9.9";
  expectError(ErrorCode::kFormat, "beyond what a float can hold", options);
}

// Known: the damaged file is cut inside its pixels, behind its series, or inside its first group, before its series.
TEST_F(DicomSeries, DamagedFile_isAnErrorOfItsSeriesAndElseNoted) {
  writeAt({{0, 0, 0}, {0, 0, 2}});
  DicomSpec other;
  other.series = "9.9";
  files_.write("y", slice(other, 5));
  const std::string whole = slice(other, 5);
  files_.write("z", whole.substr(0, whole.size() - 60));
  expectError(ErrorCode::kUsage, "9.9 (CT 'a series', 1 slice); 'z' cannot be read (");
  SourceOptions options;
  options.series = "9.9";
  expectError(ErrorCode::kFormat, "z: byte", options);
  for (const std::size_t bytes : {whole.size() - 60, std::size_t{150}}) {
    files_.write("z", whole.substr(0, bytes));
    options.series = DicomSpec().series;
    EXPECT_EQ(order(options), (std::vector{0, 1}));
    const auto notes = open(options)->info().notes;
    EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const auto& note) {
      return note.starts_with("passed over 'z'") && note.find(": cannot be read (") != std::string::npos;
    }));
  }
  for (const char* const name : {"a", "b", "y"}) fs::remove(files_.directory() / name);
  expectError(ErrorCode::kFormat, "z: byte");
}

// Known: archives name folders and files by identifiers, whose last number looks like an ending.
TEST_F(DicomSeries, FolderNamedByAnIdentifier_IsSearched) {
  const fs::path folder = files_.directory() / "1.3.6.7";
  fs::create_directories(folder);
  for (int i = 0; i < 8; ++i) {
    DicomSpec spec;
    spec.position = triple({0, 0, 2 * i});
    files_.write("1.3.6.7/CT.1.3.6.7." + std::to_string(i), slice(spec, i));
  }
  EXPECT_EQ(order(), (std::vector{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST_F(DicomSeries, SlopeOfZeroAndWhiteZero_AreNoted) {
  DicomSpec spec;
  spec.slope = "0", spec.intercept = "-5";
  writeAt({{0, 0, 0}, {0, 0, 2}}, spec);
  EXPECT_EQ(open()->info().notes,
            std::vector<std::string>{"'a': RescaleSlope (0028,1053) is 0, which no value survives; 1 is taken"});
  spec = {}, spec.photometric = "MONOCHROME1";
  writeAt({{0, 0, 0}, {0, 0, 2}}, spec);
  ASSERT_EQ(open()->info().notes.size(), 1u);
  EXPECT_TRUE(open()->info().notes[0].starts_with("the DICOM files show their smallest values white (MONOCHROME1)"));
}

// Known because each slice stores its position: a broken link moves no slice, and a missing slice is a gap.
TEST_F(DicomSeries, LinksToNothingArePassedOver) {
  writeAt({{0, 0, 0}, {0, 0, 2}, {0, 0, 4}, {0, 0, 6}});
  fs::create_symlink("nowhere", files_.directory() / "gone");
  fs::create_symlink("loop", files_.directory() / "loop");
  const auto source = open();
  EXPECT_EQ(source->info().geometry.dims.z, 4);
  EXPECT_EQ(std::count(source->info().notes.begin(), source->info().notes.end(),
                       "passed over 'loop' and 1 more: links to nothing"),
            1);
  fs::remove(files_.directory() / "c");
  expectError(ErrorCode::kFormat, "");
}

// A screenshot, a localizer and a report in the series itself, a presentation state beside it. The volume consists of
// the majority of slices, and each other object is named with its reason.
TEST_F(DicomSeries, OtherObjectsOfASeries_arePassedOverWithTheirReason) {
  writeAt({{0, 0, 0}, {0, 0, 2}, {0, 0, 4}});
  DicomSpec other;
  other.columns = 4, other.position = "0\\0\\9";
  files_.write("localizer", slice(other, 9));
  other = {}, other.samples = 3, other.photometric = "RGB", other.modality = "SC";
  files_.write("screen", slice(other, 9));
  other = {}, other.pixels = other.image = false, other.modality = "SR";
  files_.write("report", dicomFile(other));
  other.series = "1.2.77", other.modality = "PR";
  files_.write("state", dicomFile(other));
  EXPECT_EQ(order(), (std::vector{0, 1, 2}));
  const std::vector<std::string> expected = {
      "passed over 'report' (SR) and 1 more: has no pixel data",
      "passed over 'screen' (SC): holds 3 samples a pixel ('RGB'); Kiln reads one",
      "passed over 'localizer' (CT): is 4 x 4 pixels where 3 slices of its series are 5 x 4"};
  std::vector<std::string> found = open()->info().notes;
  EXPECT_TRUE(std::is_permutation(found.begin(), found.end(), expected.begin(), expected.end()))
      << testing::PrintToString(found);
  // A slice with missing pixels is an error, not another object.
  other = {}, other.pixels = false, other.position = "0\\0\\6";
  files_.write("d", dicomFile(other));
  expectError(ErrorCode::kFormat, "d: has no pixel data, but is of the series");
}

// With equally many slices of two sizes, neither is the majority.
TEST_F(DicomSeries, AsManySlicesOfTwoSizes_areAnError) {
  writeAt({{0, 0, 0}});
  DicomSpec other;
  other.columns = 4, other.position = "0\\0\\2";
  files_.write("b", slice(other, 9));
  expectError(ErrorCode::kFormat, "1 slice of 4 x 4 pixels (as 'b') and as many of 5 x 4 (as 'a')");
}

// Known because both files have equal names.
TEST_F(DicomSeries, SlicesOfSeveralFolders_areNamedWithTheirFolders) {
  for (const char* folder : {"a", "b"}) {
    fs::create_directories(files_.directory() / folder);
    files_.write(std::string(folder) + "/0", slice(DicomSpec(), 1));
  }
  expectError(ErrorCode::kUnsupported, "'a/0' and 'b/0' lie at the same place");
}

// A CD: a DICOMDIR and nested folders. Opening the DICOMDIR, or its folder, lists all series.
TEST_F(DicomSeries, DicomdirAndNestedFolders_listTheirSeries) {
  const auto write = [&](const std::string& folder, const DicomSpec& spec, int number) {
    fs::create_directories(files_.directory() / folder);
    files_.write(folder + "/" + std::to_string(number), slice(spec, number));
  };
  DicomSpec head, chest;
  head.series = "1.2.10", chest.series = "1.2.11", chest.description = "chest";
  for (int i = 0; i < 3; ++i) {
    head.position = chest.position = "0\\0\\" + std::to_string(2 * i);
    write("disc/P1/S1", head, i);
    write("disc/P1/S2", chest, i + 5);
  }
  const fs::path disc = files_.directory() / "disc";
  const std::string list =
      "holds 2 series; choose one with --series: 1.2.10 (CT 'a series', 3 slices), 1.2.11 (CT 'chest', 3 slices)";
  SourceOptions options;
  options.series = "1.2.11";
  const auto expectChest = [&](const fs::path& input, std::size_t notes) {
    expectRefused(input, ErrorCode::kUsage, list);
    const auto source = openSource(input, options);
    EXPECT_EQ(readWhole(*source)[0], std::byte{5});
    EXPECT_EQ(source->info().geometry.dims.z, 3);
    EXPECT_EQ(source->info().notes.size(), notes) << testing::PrintToString(source->info().notes);
  };
  expectChest(disc, 1);
  files_.write("disc/DICOMDIR", dicomDirectory({"P1\\S1\\0", "p1\\s1\\1", "P1\\S2\\5"}));
  std::error_code ignored;
  fs::remove(disc / "P1/S1/1", ignored);
  options.series = "1.2.10", options.allow_irregular = true;
  const std::vector<std::string> notes = openSource(disc / "DICOMDIR", options)->info().notes;
  EXPECT_NE(std::find(notes.begin(), notes.end(), "DICOMDIR lists 1 file that is not there: 'p1/s1/1'"), notes.end())
      << testing::PrintToString(notes);
  head.position = "0\\0\\2";
  write("disc/P1/S1", head, 1);
  options.series = "1.2.11", options.allow_irregular = false;
  files_.write("disc/DICOMDIR", dicomDirectory({"P1\\S1\\0", "P1\\S2\\5"}));
  expectChest(disc / "DICOMDIR", 1);
  expectChest(disc, 1);
  // Slices of a folder's own come first, and TIFF slices are not searched for.
  head.position = "0\\0\\0", head.series = "1.2.12";
  files_.write("one.dcm", slice(head, 9));
  EXPECT_EQ(openSource(files_.directory())->info().geometry.dims.z, 1);
  const std::vector<std::string> beside = openSource(files_.directory())->info().notes;
  EXPECT_NE(testing::PrintToString(beside).find("DICOM files in folders below, as 'disc/"), std::string::npos)
      << testing::PrintToString(beside);
  const ForeignFiles tiffs;
  fs::create_directories(tiffs.directory() / "a");
  tiffs.write("a/s1.tif", std::string("II*\0", 4));
  expectRefused(tiffs.directory(), ErrorCode::kUnsupported, "name the folder that holds the slices");
}

TEST_F(DicomSeries, SeveralSeriesAreListedAndOneIsChosen) {
  DicomSpec head, scout, report;
  head.series = "1.2.10", head.description = "head 1.0";
  scout.series = "1.2.9", scout.description = "scout", scout.photometric = "PALETTE COLOR";
  report.series = "1.2.8", report.pixels = false;
  writeAt({{0, 0, 0}, {0, 0, 2}}, head);
  files_.write("x", slice(scout, 7));
  files_.write("y", dicomFile(report));
  files_.write("z.txt", "notes");
  expectError(
      ErrorCode::kUsage,
      "holds 2 series; choose one with --series: 1.2.10 (CT 'head 1.0', 2 slices), 1.2.9 (CT 'scout', 1 slice)");
  SourceOptions options;
  options.series = "1.2.10";
  EXPECT_EQ(order(options), (std::vector{0, 1}));
  const SourceInfo info = open(options)->info();
  EXPECT_NE(info.format.find("1.2.10"), std::string::npos);
  EXPECT_EQ(info.files.size(), 3u);
  EXPECT_EQ(info.notes.size(), 3u);
  options.series = "1.2.9";
  expectError(ErrorCode::kUnsupported, "x: holds indices into a palette", options);
  options.series = "1.2";
  expectError(ErrorCode::kUsage, "--series 1.2: is not among", options);
  files_.write("t.tif", std::string("II*\0", 4));
  expectError(ErrorCode::kUnsupported, "put them apart");
  expectRefused(files_.write("v.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\nx"),
                ErrorCode::kUsage, "--series", options);
}

TEST_F(DicomSeries, WithoutPositionsTheNumbersDecide) {
  DicomSpec spec;
  spec.position = spec.orientation = "";
  spec.spacing = "0.5\\0.25", spec.thickness = "3";
  const char* const numbers[] = {"10", "9", "2"};
  for (int i = 0; i < 3; ++i) {
    spec.instance = numbers[i];
    files_.write(std::string(1, static_cast<char>('a' + i)), slice(spec, i));
  }
  EXPECT_EQ(order(), (std::vector{2, 1, 0}));
  const SourceInfo info = open()->info();
  EXPECT_EQ(info.geometry.spacing(), glm::dvec3(0.25, 0.5, 3));
  EXPECT_EQ(info.geometry.frame, PatientFrame::kUnknown);
  EXPECT_EQ(info.notes.size(), 1u);
  SourceOptions options;
  options.spacing = glm::dvec3(1, 2, 3);
  EXPECT_EQ(open(options)->info().geometry.spacing(), glm::dvec3(1, 2, 3));
}

// Repeated numbers, such as phases of a heart, are several volumes; if all numbers are equal, they are no slice
// numbers.
TEST_F(DicomSeries, WithoutPositionsNumbersThatRepeatAreSeveralVolumes) {
  DicomSpec spec;
  spec.position = spec.orientation = "";
  for (int i = 0; i < 4; ++i) {
    spec.instance = std::to_string(i % 2 + 1);
    files_.write(std::string(1, static_cast<char>('a' + i)), slice(spec, i));
  }
  expectError(ErrorCode::kUnsupported, "'a' and 'c' have the same number");
  spec.instance = "1";
  for (int i = 0; i < 4; ++i) files_.write(std::string(1, static_cast<char>('a' + i)), slice(spec, i));
  EXPECT_EQ(order(), (std::vector{0, 1, 2, 3}));
}

TEST_F(DicomSeries, FramesOfOneFileLieWhereTheirGroupsSay) {
  DicomSpec spec;
  spec.frames = 3;
  spec.frame_positions = {"0\\0\\4", "0\\0\\0", "0\\0\\2"};
  spec.spacing = "0.5\\0.25", spec.intercept = "-10", spec.slope = "1";
  spec.pixel_bytes = std::string(120, '\0');
  for (std::size_t i = 0; i < 3; ++i) spec.pixel_bytes[40 * i] = static_cast<char>(i + 20);
  for (const DicomSyntax syntax : {DicomSyntax::kExplicitLittle, DicomSyntax::kImplicitLittle}) {
    spec.syntax = syntax;
    files_.write("a", dicomFile(spec));
    EXPECT_EQ(order(), (std::vector{11, 12, 10}));
    expectNear(open()->info().geometry.worldOf({1, 1, 1}), {0.25, 0.5, 2});
  }
}

// A single slice is a volume a voxel thick, with the thickness in its header.
TEST_F(DicomSeries, OneSliceOpens) {
  DicomSpec spec;
  spec.thickness = "2.5";
  const auto source = openSource(files_.write("one.dcm", slice(spec, 3)));
  EXPECT_EQ(source->info().geometry.dims, (Extent3{5, 4, 1}));
  EXPECT_EQ(source->info().geometry.spacing(), glm::dvec3(1, 1, 2.5));
  EXPECT_EQ(source->info().notes.size(), 0u);
}

}  // namespace
}  // namespace kiln::test
