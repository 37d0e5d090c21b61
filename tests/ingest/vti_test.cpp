// Images of VTK in XML. Known because the test's writer puts text and bytes together by VTK's description.
#include <gtest/gtest.h>

#include "ingest/open_source.h"
#include "support/files/foreign_files.h"
#include "support/files/header_writer.h"
#include "support/files/vti_files.h"

namespace kiln::test {
namespace {

TEST(IngestVti, EveryFormatCodecAndOrderReadsBack) {
  const ForeignFiles files;
  for (const VoxelType type : {VoxelType::u8, VoxelType::i16, VoxelType::f32, VoxelType::f64}) {
    const ForeignVolume volume = randomVolume({13, 9, 7}, type, 401);
    for (const char* format : {"raw", "base64", "binary", "ascii"}) {
      for (int codec = 0; codec < (format == std::string("ascii") ? 1 : 4); ++codec) {
        for (const bool big : {false, true}) {
          SCOPED_TRACE(testing::Message() << nameOf(type) << " " << format << " codec " << codec << " big " << big);
          VtiLayout layout;
          layout.format = format, layout.codec = codec, layout.big = big, layout.wide = codec % 2 == 0;
          // 819 voxels: the last block is shorter, or there is a single one.
          layout.block_bytes = type == VoxelType::u8 ? 4096 : 100;
          expectReadsBack(volume, files.write("a.vti", vtiFile(volume, layout)), 402);
        }
      }
    }
  }
  // Blocks that fill the array exactly have no last one.
  const ForeignVolume even = randomVolume({8, 4, 4}, VoxelType::u16, 403);
  VtiLayout layout;
  layout.codec = 1;
  expectReadsBack(even, files.write("a.vti", vtiFile(even, layout)), 404);
}

TEST(IngestVti, SeveralThreadsReadCompressedBlocksAtOnce) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({40, 30, 20}, VoxelType::u16, 411);
  VtiLayout layout;
  layout.codec = 2, layout.block_bytes = 1000;
  const auto source = openSource(files.write("a.vti", vtiFile(volume, layout)));
  ASSERT_EQ(source->order(), ReadOrder::kAnyBox);
  source->keepDecoded(5000);
  expectThreadsReadBack(volume, *source);
}

// Known: a point lies at origin + direction * (spacing * index), and indices begin at the extent.
TEST(IngestVti, ExtentDirectionAndCellsAreTheAffine) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 421);
  VtiLayout layout;
  layout.extent = "10 14 -3 0 7 9";
  layout.image = "Origin=\"100 200 300\" Spacing=\"2 3 4\"";
  const auto plain = openSource(files.write("a.vti", vtiFile(volume, layout)));
  EXPECT_EQ(plain->info().geometry.dims, volume.dims);
  EXPECT_EQ(plain->info().geometry.worldOf({0, 0, 0}), glm::dvec3(120, 191, 328));
  EXPECT_EQ(plain->info().geometry.worldOf({1, 1, 1}), glm::dvec3(122, 194, 332));
  layout.image += " Direction=\"0 -1 0 1 0 0 0 0 1\"";
  const auto turned = openSource(files.write("b.vti", vtiFile(volume, layout)));
  EXPECT_EQ(turned->info().geometry.worldOf({0, 0, 0}), glm::dvec3(100 + 9, 200 + 20, 328));
  EXPECT_EQ(turned->info().geometry.worldOf({1, 0, 0}), glm::dvec3(109, 222, 328));
  EXPECT_EQ(turned->info().geometry.worldOf({0, 1, 0}), glm::dvec3(106, 220, 328));
  layout.kind = "CellData", layout.extent = "10 15 -3 1 7 10", layout.image = "Origin=\"0 0 0\" Spacing=\"2 3 4\"";
  const auto cells = openSource(files.write("c.vti", vtiFile(volume, layout)));
  EXPECT_EQ(cells->info().geometry.dims, volume.dims);
  EXPECT_EQ(cells->info().geometry.worldOf({0, 0, 0}), glm::dvec3(21, -7.5, 30));
  EXPECT_TRUE(readWhole(*cells) == volume.voxels);
  SourceOptions options;
  options.spacing = glm::dvec3(1, 1, 1);
  EXPECT_EQ(openSource(files.directory() / "c.vti", options)->info().geometry.worldOf({0, 0, 0}),
            glm::dvec3(10.5, -2.5, 7.5));
  expectRefused(files.directory() / "b.vti", ErrorCode::kUsage, "--spacing", options);
}

TEST(IngestVti, ActiveScalarsOrTheChosenArray_areRead) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::i16, 431);
  VtiLayout layout;
  layout.format = "ascii";
  std::string zeros;
  for (int i = 0; i < 60; ++i) zeros += " 7";
  layout.more_arrays =
      "<DataArray type=\"UInt8\" Name=\"w\" format=\"ascii\">" + zeros +
      "</DataArray><DataArray type=\"Float32\" Name=\"flow\" NumberOfComponents=\"3\" format=\"ascii\"/>";
  expectReadsBack(volume, files.write("a.vti", vtiFile(volume, layout)), 432);
  EXPECT_EQ(openSource(files.directory() / "a.vti")->info().notes,
            std::vector<std::string>{"array 'v' is read, and not 'w'; --channel chooses"});
  layout.scalars = "";
  const auto path = files.write("a.vti", vtiFile(volume, layout));
  expectRefused(path, ErrorCode::kUsage, "holds 2 channels; choose one with --channel, from 0 to 1: 0 ('w'), 1 ('v')");
  SourceOptions options;
  for (const char* name : {"w", "0"}) {
    options.channel = name;
    const auto source = openSource(path, options);
    EXPECT_EQ(source->info().type, VoxelType::u8);
    EXPECT_EQ(source->info().format, "VTK image, channel 0");
    EXPECT_TRUE(source->info().notes.empty());
    EXPECT_TRUE(readWhole(*source) == std::vector<std::byte>(60, std::byte{7}));
  }
  options.channel = "flow";
  expectRefused(path, ErrorCode::kUsage, "--channel: 'flow' is none of the channels", options);
}

// Known: VTK writes the range of an array as elements inside the array's own.
TEST(IngestVti, InformationInsideAnArray_HidesNoLaterArray) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::i16, 435);
  const std::string key =
      "<InformationKey name=\"L2_NORM_RANGE\" location=\"vtkDataArray\" length=\"1\"><Value index=\"0\">7</Value>"
      "</InformationKey>";
  VtiLayout layout;
  layout.more_arrays = "<DataArray type=\"UInt8\" Name=\"w\" format=\"appended\" offset=\"0\">" + key + "</DataArray>";
  expectReadsBack(volume, files.write("a.vti", vtiFile(volume, layout)), 436);
}

// Known: arrays of a FieldData element belong to no point and no cell.
TEST(IngestVti, FieldDataBehindThePiece_AreNoVoxels) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::i16, 437);
  VtiLayout layout;
  layout.scalars = "";
  std::string whole = vtiFile(volume, layout);
  whole.insert(whole.find("</ImageData>"),
               "<FieldData><DataArray type=\"UInt8\" Name=\"w\" format=\"appended\" offset=\"0\"/></FieldData>");
  expectReadsBack(volume, files.write("a.vti", whole), 438);
}

TEST(IngestVti, OtherDataAreRefusedByName) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 441);
  const std::string whole = vtiFile(volume, {});
  const auto refused = [&](const std::string& from, const std::string& to, ErrorCode code, const std::string& part) {
    expectRefused(files.write("a.vti", replaced(whole, from, to)), code, part);
  };
  refused("\"ImageData\"", "\"UnstructuredGrid\"", ErrorCode::kUnsupported, "'UnstructuredGrid', not an image");
  refused("\"ImageData\"", "\"PImageData\"", ErrorCode::kUnsupported, "pieces of an image in other files");
  refused("</Piece>", "</Piece><Piece Extent=\"0 1 0 1 0 1\"></Piece>", ErrorCode::kUnsupported, "several pieces");
  refused("\"UInt8\"", "\"String\"", ErrorCode::kUnsupported, "found 'v' of 1 x 'String'");
  refused("Name=\"v\"", "Name=\"v\" NumberOfComponents=\"3\"", ErrorCode::kUnsupported, "found 'v' of 3 x 'UInt8'");
  refused("header_type", "compressor=\"zip\" header_type", ErrorCode::kUnsupported, "'zip' is not a compressor");
  refused("<VTKFile", "<!DOCTYPE a [<!ENTITY b \"c\">]><VTKFile", ErrorCode::kFormat, "document type");
  refused("LittleEndian", "Middle", ErrorCode::kFormat, "'Middle' is no byte order");
  refused("Piece Extent=\"0 4", "Piece Extent=\"0 x", ErrorCode::kFormat, "Extent: expected 6 numbers");
  refused("Piece Extent=\"0 4", "Piece Extent=\"5 4", ErrorCode::kFormat, "the extent along x is 5 to 4");
  refused("Piece Extent=\"0 4", "Piece Extent=\"0 5", ErrorCode::kFormat, "the array has 60 bytes");
  refused("offset=\"5\"", "offset=\"5000\"", ErrorCode::kFormat, "beyond the end");
  refused("offset=\"5\"", "offset=\"-1\"", ErrorCode::kFormat, "offset is -1");
  refused("_other", "other", ErrorCode::kFormat, "underscore");
  refused("<PointData", "<PointData><a", ErrorCode::kFormat, "damaged");
  std::string deep = whole;
  for (int i = 0; i < 40; ++i) deep.insert(deep.find("<PointData"), "<a>");
  expectRefused(files.write("a.vti", deep), ErrorCode::kFormat, "elements lie more than 32 deep");
  expectRefused(files.write("a.vti", "<VTKFile " + std::string(3 << 20, 'x')), ErrorCode::kFormat, "no end");
}

// Lengths that lie are refused before memory is taken for them.
TEST(IngestVti, HostileLengthsAreFormatErrors) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u16, 451);
  VtiLayout layout;
  layout.codec = 1, layout.wide = true;
  const std::string whole = vtiFile(volume, layout);
  const std::size_t table = whole.find("_other") + 6;
  const auto refused = [&](std::size_t at, std::uint64_t value, const std::string& part) {
    std::string wrong = whole;
    putNumber(wrong, table + 8 * at, value);
    expectRefused(files.write("a.vti", wrong), ErrorCode::kFormat, part);
  };
  for (const std::uint64_t value : {std::uint64_t{0}, std::uint64_t{1} << 62, UINT64_MAX}) {
    refused(0, value, "blocks of");
    refused(1, value, "blocks of");
    refused(2, value, "blocks of");
  }
  refused(3, UINT64_MAX, "packed bytes");
  refused(3, 1, "damaged");
  refused(4, 1 << 20, "packed bytes");
}

// Known: the only block is the last one, which is as long as the array, whatever the length of the others.
TEST(IngestVti, MemoryOfABlock_IsNoMoreThanTheArray) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u16, 455);
  for (const int codec : {1, 3}) {
    VtiLayout layout;
    layout.codec = codec, layout.wide = true, layout.block_bytes = 4096;
    std::string whole = vtiFile(volume, layout);
    const std::uint64_t packed_bytes = vtiBlock(volume.stored(false), codec).size();
    putNumber(whole, whole.find("_other") + 6 + 8, UINT64_MAX);
    const auto source = openSource(files.write("a.vti", whole));
    EXPECT_EQ(source->decodeBytes(), 120 + packed_bytes + (codec == 3 ? 64 << 20 : 0));
    EXPECT_TRUE(readWhole(*source) == volume.voxels);
  }
}

TEST(IngestVti, EveryCutIsNoticedAndFlipsAreHarmless) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u16, 461);
  for (const char* format : {"raw", "base64", "binary", "ascii"}) {
    for (const int codec : {0, 1}) {
      if (codec == 1 && format == std::string("ascii")) continue;
      SCOPED_TRACE(format);
      VtiLayout layout;
      layout.format = format, layout.codec = codec;
      std::string whole = vtiFile(volume, layout);
      // The XML behind appended data is not read.
      const std::size_t end = whole.find("\n</AppendedData>");
      if (end != std::string::npos)
        whole.resize(end);
      else
        whole.pop_back();
      expectNoCutGoesUnnoticed(volume, files, "a.vti", whole, files.directory() / "a.vti");
      expectBitFlipsAreHarmless(files, "a.vti", whole, whole.size(), files.directory() / "a.vti", 462);
    }
  }
}

}  // namespace
}  // namespace kiln::test
