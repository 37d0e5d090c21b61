// Binary segmentation objects. Known because the test writes the bits of each frame, the lowest bit of a byte first and
// without padding between frames, and the position and the segment of each frame.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "ingest/open_source.h"
#include "ingest/volume_list.h"
#include "support/files/dicom_files.h"
#include "support/files/foreign_files.h"

namespace kiln::test {
namespace {

// Bits of frames of 5 x 3 pixels, a text each of '.' and '#'.
std::string bitsOf(const std::vector<std::string>& frames) {
  std::string out;
  std::size_t bit = 0;
  for (const std::string& frame : frames) {
    for (const char pixel : frame) {
      if (bit % 8 == 0) out += '\0';
      if (pixel == '#') out.back() = static_cast<char>(out.back() | 1 << bit % 8);
      ++bit;
    }
  }
  return out;
}

// Frames in no order, at heights 0, 3 and 1 planes of 2 mm; plane 2 is left out, and two segments share plane 1.
DicomSpec segmentation(DicomSyntax syntax = DicomSyntax::kExplicitLittle) {
  DicomSpec spec;
  spec.syntax = syntax;
  spec.segmentation = "BINARY";
  spec.modality = "SEG";
  spec.columns = 5, spec.rows = 3, spec.frames = 4;
  spec.bits_allocated = spec.bits_stored = 1;
  spec.is_signed = false;
  spec.thickness = "2";
  spec.spacing = "0.5\\0.25";
  spec.frame_positions = {"1\\2\\36", "1\\2\\30", "1\\2\\32", "1\\2\\32"};
  spec.frame_segments = {3, 9, 9, 3};
  spec.pixel_bytes = bitsOf({"#.............#", ".....#####.....", "..#.....#......", "###............"});
  return spec;
}

constexpr const char* kExpected[] = {".....99999.....", "339.....9......", "...............", "3.............3"};

ForeignVolume expectedVolume() {
  ForeignVolume out{{5, 3, 4}, VoxelType::u8, {}};
  for (const std::string plane : kExpected)
    for (const char c : plane) out.voxels.push_back(static_cast<std::byte>(c == '.' ? 0 : c - '0'));
  return out;
}

TEST(DicomSegmentation, FramesBecomeLabelsInTheirPlanes) {
  const ForeignFiles files;
  for (const DicomSyntax syntax :
       {DicomSyntax::kExplicitLittle, DicomSyntax::kImplicitLittle, DicomSyntax::kDeflated}) {
    const auto path = files.write("seg.dcm", dicomFile(segmentation(syntax)));
    expectReadsBack(expectedVolume(), path, 811);
    const auto source = openSource(path);
    EXPECT_EQ(source->info().volume_class, VolumeClass::kLabels);
    EXPECT_EQ(source->info().geometry.worldOf({0, 0, 0}), glm::dvec3(1, 2, 30));
    EXPECT_EQ(source->info().geometry.worldOf({1, 1, 1}), glm::dvec3(1.25, 2.5, 32));
    EXPECT_EQ(source->info().notes, std::vector<std::string>{"where segments overlap, the one with the greatest number "
                                                             "is taken"});
    EXPECT_EQ(volumesIn(path, {}).at(0).dims, (Extent3{5, 3, 4}));
  }
}

// The planes are 2.5 mm apart, whatever the thickness of a slice. The last two frames, of two segments, lie in one
// plane.
void expectPlanesOf(const char* thickness, const char* last_position) {
  SCOPED_TRACE(thickness);
  const ForeignFiles files;
  DicomSpec spec = segmentation();
  spec.thickness = thickness;
  spec.frame_positions = {"1\\2\\37.5", "1\\2\\30", "1\\2\\32.5", last_position};
  const auto path = files.write("seg.dcm", dicomFile(spec));
  expectReadsBack(expectedVolume(), path, 814);
  EXPECT_EQ(openSource(path)->info().geometry.worldOf({0, 0, 1}), glm::dvec3(1, 2, 32.5));
}

TEST(DicomSegmentation, ThicknessIsNotTheDistanceOfPlanes) {
  for (const char* const thickness : {"5", "1.25", "2.4"}) expectPlanesOf(thickness, "1\\2\\32.5");
}

// Known because the planes lie at multiples of 0.7031 mm, rounded to a hundredth; the smallest gap is 0.7 mm.
TEST(DicomSegmentation, RoundedPositions_areMeanGapsApart) {
  const ForeignFiles files;
  DicomSpec spec = segmentation();
  spec.thickness = "1";
  spec.frames = 100;
  spec.frame_segments.assign(100, 1);
  spec.frame_positions.clear();
  for (int i = 0; i < 100; ++i) spec.frame_positions.push_back(fmt::format("0\\0\\{:.2f}", 0.7031 * i));
  spec.pixel_bytes = bitsOf(std::vector<std::string>(100, "#.............."));
  const auto source = openSource(files.write("seg.dcm", dicomFile(spec)));
  EXPECT_EQ(source->info().geometry.dims, (Extent3{5, 3, 100}));
  EXPECT_NEAR(source->info().geometry.spacing().z, 0.7031, 1e-4);
}

// A micrometre is more than a thousandth of a pixel.
TEST(DicomSegmentation, NoiseOfPositions_isNotTheDistanceOfPlanes) {
  for (const char* const thickness : {"2.5", "250", ""}) expectPlanesOf(thickness, "1\\2\\32.501");
}

TEST(DicomSegmentation, NumbersBeyondAByte_takeTwo) {
  const ForeignFiles files;
  DicomSpec spec = segmentation();
  spec.frame_segments = {300, 9, 9, 300};
  const auto source = openSource(files.write("seg.dcm", dicomFile(spec)));
  ASSERT_EQ(source->info().type, VoxelType::u16);
  const std::vector<std::byte> voxels = readWhole(*source);
  EXPECT_EQ(voxels[2 * 45], std::byte{300 % 256});
  EXPECT_EQ(voxels[2 * 45 + 1], std::byte{1});
  EXPECT_EQ(voxels[2 * 5], std::byte{9});
}

// Known because the test writes a byte for each pixel: segment 9 at planes 0 and 1, segment 3 at planes 3 and 1.
TEST(DicomSegmentation, FractionsOfASegment_areAmounts) {
  const ForeignFiles files;
  for (const DicomSyntax syntax : {DicomSyntax::kExplicitLittle, DicomSyntax::kDeflated}) {
    DicomSpec spec = segmentation(syntax);
    spec.segmentation = "FRACTIONAL", spec.bits_allocated = spec.bits_stored = 8;
    spec.pixel_bytes.clear();
    for (int i = 0; i < 4 * 15; ++i) spec.pixel_bytes += static_cast<char>(3 * i + 1);
    const auto path = files.write("seg.dcm", dicomFile(spec));
    ForeignVolume expected{{5, 3, 4}, VoxelType::u8, std::vector<std::byte>(60)};
    for (int i = 0; i < 30; ++i) expected.voxels[i] = static_cast<std::byte>(3 * (i + 15) + 1);
    SourceOptions options;
    options.channel = "segment 9";
    const auto open = [&] { return openSource(path, options); };
    expectReadsBack(expected, open, 813);
    EXPECT_EQ(open()->info().volume_class, VolumeClass::kUnknown);
    EXPECT_EQ(open()->info().notes, std::vector<std::string>{"values are fractions of segment 9, from 0 to 255"});
    expectRefused(path, ErrorCode::kUsage, "'segment 3'");
    spec.frame_segments = {9, 9, 9, 9};
    expectRefused(files.write("two.dcm", dicomFile(spec)), ErrorCode::kFormat,
                  "frame 4: lies where frame 3 lies, and both hold fractions of segment 9");
    spec = segmentation(syntax), spec.segmentation = "BINARY";
    options.channel = "1";
    expectRefused(files.write("bits.dcm", dicomFile(spec)), ErrorCode::kUsage, "--channel", options);
  }
}

TEST(DicomSegmentation, FramesThatAreNoVolume_areRefused) {
  const ForeignFiles files;
  const auto refused = [&](const DicomSpec& spec, ErrorCode code, const std::string& part) {
    expectRefused(files.write("seg.dcm", dicomFile(spec)), code, part);
  };
  DicomSpec spec = segmentation();
  spec.segmentation = "FRACTIONAL";
  refused(spec, ErrorCode::kUnsupported, "holds fractions of segments in 1 bits");
  spec = segmentation(), spec.frame_segments.pop_back();
  refused(spec, ErrorCode::kFormat, "frame 4: names no segment");
  spec = segmentation(), spec.frame_positions[0] = "1\\2\\35";
  refused(spec, ErrorCode::kFormat, "frame 1: lies 5 mm above the lowest frame");
  spec = segmentation(), spec.frame_positions[2] = "1\\3\\32";
  refused(spec, ErrorCode::kFormat, "frame 3: lies beside the line");
  spec = segmentation(), spec.orientation = "1\\0\\0\\1\\0\\0";
  refused(spec, ErrorCode::kFormat, "frame 1: the orientation is not two unit vectors");
  spec = segmentation(), spec.frame_positions[1] = "1\\2\\-1e300";
  refused(spec, ErrorCode::kFormat, "frame 1: ");
  spec = segmentation(), spec.frame_positions.pop_back();
  refused(spec, ErrorCode::kFormat, "frame 4: has no group of its own");
  refused(segmentation(DicomSyntax::kExplicitBig), ErrorCode::kUnsupported, "segments in big-endian words");
  spec = segmentation(), spec.pixel_bytes.resize(6);
  refused(spec, ErrorCode::kFormat, "there are 6 bytes");
  SourceOptions options;
  options.spacing = glm::dvec3(1);
  expectRefused(files.write("seg.dcm", dicomFile(segmentation())), ErrorCode::kUsage, "--spacing", options);
  files.write("two.dcm", dicomFile(segmentation()));
  expectRefused(files.directory(), ErrorCode::kUsage, "holds 2 segmentation objects in one series; name the file");
}

TEST(DicomSegmentation, EachObjectIsListed_AFaultyOneWithTheReason) {
  const ForeignFiles files;
  DicomSpec faulty = segmentation();
  faulty.frame_positions[2] = "1\\3\\32";
  const auto alone = files.write("a.dcm", dicomFile(faulty));
  EXPECT_NE(volumesIn(alone, {}).at(0).refusal.find("frame 3: lies beside the line"), std::string::npos);
  const auto whole = files.write("b.dcm", dicomFile(segmentation()));
  faulty = segmentation(), faulty.slope = "1e60";
  files.write("c.dcm", dicomFile(faulty));
  const std::vector<ListedVolume> listed = volumesIn(files.directory(), {});
  ASSERT_EQ(listed.size(), 3u);
  EXPECT_NE(listed[0].refusal.find("a.dcm: frame 3: lies beside the line"), std::string::npos) << listed[0].refusal;
  EXPECT_EQ(listed[1].refusal, "");
  EXPECT_EQ(listed[1].dims, (Extent3{5, 3, 4}));
  EXPECT_EQ(listed[1].option, whole.string());
  EXPECT_NE(listed[2].refusal.find("beyond what a float can hold"), std::string::npos) << listed[2].refusal;
}

TEST(DicomSegmentation, EveryCutIsNoticedAndFlipsAreHarmless) {
  const ForeignFiles files;
  const std::string whole = dicomFile(segmentation());
  const auto path = files.write("seg.dcm", whole);
  expectNoCutGoesUnnoticed(expectedVolume(), files, "seg.dcm", whole, path);
  expectBitFlipsAreHarmless(files, "seg.dcm", whole, whole.size(), path, 812);
}

}  // namespace
}  // namespace kiln::test
