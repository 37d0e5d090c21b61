// MetaImage, written here as text and bytes by the format's definition, and a real file that a NRRD header describes
// too.
#include <gtest/gtest.h>

#include <cstring>

#include "ingest/open_source.h"
#include "support/files/foreign_files.h"

namespace kiln::test {
namespace {

constexpr const char* kMetaImageTypes[] = {"MET_UCHAR", "MET_CHAR", "MET_USHORT", "MET_SHORT",
                                           "MET_UINT",  "MET_INT",  "MET_FLOAT",  "MET_DOUBLE"};

std::string metaImageHeader(const ForeignVolume& volume, bool big_endian, const std::string& more) {
  const Extent3& n = volume.dims;
  return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = " +
         std::string(big_endian ? "True" : "False") + "\nDimSize = " + std::to_string(n.x) + " " + std::to_string(n.y) +
         " " + std::to_string(n.z) + "\nElementType = " + kMetaImageTypes[static_cast<int>(volume.type)] + "\n" + more;
}

TEST(IngestMetaImage, EveryTypeOrderEncodingAndPlaceReadsBack) {
  // Known: the test writes the bytes; "prefix" is skipped by HeaderSize.
  const ForeignFiles files;
  for (const VoxelType type : kAllTypes) {
    for (const bool big : {false, true}) {
      const ForeignVolume volume = randomVolume({13, 9, 7}, type, 101);
      const std::string bytes = volume.stored(big);
      const auto check = [&](const std::string& name, const std::string& more, const std::string& data = "") {
        SCOPED_TRACE(name + " " + std::string(nameOf(type)) + (big ? " big" : " little"));
        const auto path = files.write(name, metaImageHeader(volume, big, more) + data);
        expectReadsBack(
            volume, [&] { return openSource(path); }, 102);
      };
      check("local.mha", "ElementDataFile = LOCAL\n", bytes);
      check("crlf.mha", "ElementDataFile = LOCAL\r\n", bytes);
      check("localz.mha", "CompressedData = True\nElementDataFile = LOCAL\n", zlibbed(bytes));
      check("localgz.mha", "CompressedData = True\nElementDataFile = LOCAL\n", gzipped(bytes));
      check("locale.mha", "HeaderSize = -1\nElementDataFile = LOCAL\n", "more" + bytes);
      files.write("d.raw", "prefix" + bytes);
      check("six.mhd", "HeaderSize = 6\nElementDataFile = d.raw\n");
      check("end.mhd", "HeaderSize = -1\nElementDataFile = d.raw");
      files.write("d.zraw", zlibbed(bytes));
      check("z.mhd", "CompressedData = True\nElementDataFile = d.zraw\n");
    }
  }
}

TEST(IngestMetaImage, GeometryIsAsItkReadsIt) {
  // Known: row i of TransformMatrix times spacing i is column i of the affine.
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 111);
  const auto open = [&](const std::string& fields) {
    return openSource(files.write(
        "g.mha", metaImageHeader(volume, false, fields + "ElementDataFile = LOCAL\n") + volume.stored(false)));
  };
  for (const char* names : {"TransformMatrix Offset", "Rotation Origin", "Orientation Position"}) {
    const std::string both = names, matrix = both.substr(0, both.find(' ')), offset = both.substr(both.find(' ') + 1);
    const auto source = open("ElementSpacing = 2 3 4\n" + offset + " = 7 8 -9.5\n" + matrix +
                             " = 0 1 0 -1 0 0 0 0 1\nAnatomicalOrientation = RAI\n");
    const glm::dmat4 expected = {{0, 2, 0, 0}, {-3, 0, 0, 0}, {0, 0, 4, 0}, {7, 8, -9.5, 1}};
    EXPECT_TRUE(source->info().geometry.world_from_index == expected) << names;
    EXPECT_EQ(source->info().geometry.frame, PatientFrame::kLps);
  }
  const auto size = open("ElementSize = 1 1 2\nDistanceUnits = um\nAnatomicalOrientation = ???\n");
  EXPECT_EQ(size->info().geometry.spacing(), glm::dvec3(1, 1, 2));
  EXPECT_EQ(size->info().geometry.frame, PatientFrame::kUnknown);
  EXPECT_EQ(size->info().geometry.unit, "um");
}

TEST(IngestMetaImage, ListPatternAndTextReadBack) {
  // Known: as above; two files hold two slices each.
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({7, 5, 4}, VoxelType::i16, 115);
  const std::string bytes = volume.stored(true);
  files.write("s1.raw", bytes.substr(0, bytes.size() / 2)), files.write("s2.raw", bytes.substr(bytes.size() / 2));
  for (const char* names : {"LIST\ns1.raw\ns2.raw\n", "LIST 3D\ns1.raw\ns2.raw", "s%d.raw 1 2 1\n"})
    expectReadsBack(
        volume, files.write("a.mhd", metaImageHeader(volume, true, std::string("ElementDataFile = ") + names)), 116);
  const std::string header =
      replaced(metaImageHeader(volume, true, "ElementDataFile = LOCAL\n"), "BinaryData = True", "BinaryData = False");
  expectReadsBack(volume, files.write("t.mha", header + decimalsOf(volume, " \n")), 117);
}

TEST(IngestMetaImage, WhatIsNotReadIsRefusedByName) {
  // Known: each header is legal, or wrong in exactly the field that the message must name.
  const ForeignFiles files;
  const auto refused = [&](const std::string& text, ErrorCode code, const std::string& part) {
    expectRefused(files.write("r.mha", text + std::string(64, 'x')), code, part);
  };
  const std::string start = "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\n", u8 = "ElementType = MET_UCHAR\n";
  const std::string local = "ElementDataFile = LOCAL\n";
  refused(start + "ElementType = MET_LONG\n" + local, ErrorCode::kUnsupported, "'MET_LONG' is not read");
  refused(start + "ElementType = MET_FLOAT_ARRAY\n" + local, ErrorCode::kUnsupported, "vector, tensor or colour");
  refused(start + u8 + "ElementNumberOfChannels = 3\n" + local, ErrorCode::kUnsupported, "vector, tensor or colour");
  refused(start + u8 + "BinaryData = False\n" + local, ErrorCode::kFormat, "is not a value of type u8");
  refused(start + u8 + "BinaryData = False\nCompressedData = True\n" + local, ErrorCode::kFormat,
          "text is not compressed");
  refused("ObjectType = Tube\nNDims = 3\n" + local, ErrorCode::kUnsupported, "Tube");
  refused("ObjectType = Image\nNDims = 2\nDimSize = 2 2\n" + u8 + local, ErrorCode::kUnsupported, "2-D");
  refused(start + u8 + "ElementDataFile = LIST\na.raw\n", ErrorCode::kNotFound, "'a.raw' is missing");
  refused(start + u8 + "ElementDataFile = s%03d.raw 1 9 1\n", ErrorCode::kNotFound, "'s001.raw' is missing");
  refused(start + u8 + "ElementDataFile = gone.raw\n", ErrorCode::kNotFound, "gone.raw");
  refused(start + u8 + "DimSize = 2 2 2\n" + local, ErrorCode::kFormat, "line 5: DimSize");
  refused(start + u8 + "Offset = 1 2 3\nOrigin = 1 2 4\n" + local, ErrorCode::kFormat, "line 6: Origin: contradicts");
  refused(start + u8 + "ElementSpacing = 1 0 1\n" + local, ErrorCode::kFormat, "do not span");
  refused(start + u8 + "HeaderSizePerSlice = 8\n" + local, ErrorCode::kUnsupported, "HeaderSizePerSlice");
  refused(start + u8 + "ElementToIntensityFunctionSlope = 2\n" + local, ErrorCode::kUnsupported, "linear map");
  refused(start + u8 + "HeaderSize = 5\n" + local, ErrorCode::kFormat, "inside the header");
  refused(start + u8 + "CompressedData = maybe\n" + local, ErrorCode::kFormat, "maybe");
  refused(start + u8 + "CompressedData = True\n" + local, ErrorCode::kFormat, "damaged");
}

TEST(IngestMetaImage, EveryCutIsNoticedAndFlipsAreHarmless) {
  // Known: lengths and checksums leave no cut that holds all voxels; ElementDataFile is the last line.
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::f32, 121);
  const std::string bytes = volume.stored(true), geometry = "ElementSpacing = 1 1 2.5\nOffset = 1 2 3\n";
  const std::string raw = metaImageHeader(volume, true, geometry + "ElementDataFile = LOCAL\n");
  const std::string end = metaImageHeader(volume, true, "HeaderSize = -1\nElementDataFile = LOCAL\n");
  const std::string z = metaImageHeader(volume, true, "CompressedData = True\nElementDataFile = LOCAL\n");
  const std::string detached = metaImageHeader(volume, true, geometry + "ElementDataFile = data.raw\n");
  files.write("data.raw", bytes);
  const auto in = [&](const char* name) { return files.directory() / name; };
  expectNoCutGoesUnnoticed(volume, files, "a.mha", raw + bytes, in("a.mha"));
  expectNoCutGoesUnnoticed(volume, files, "e.mha", end + bytes, in("e.mha"));
  expectNoCutGoesUnnoticed(volume, files, "b.mha", z + zlibbed(bytes), in("b.mha"));
  expectNoCutGoesUnnoticed(volume, files, "c.mhd", detached, in("c.mhd"));
  expectNoCutGoesUnnoticed(volume, files, "data.raw", bytes, in("c.mhd"));
  expectBitFlipsAreHarmless(files, "a.mha", raw + bytes, raw.size(), in("a.mha"), 122);
  expectBitFlipsAreHarmless(files, "b.mha", z + zlibbed(bytes), z.size() + 20, in("b.mha"), 123);
  expectBitFlipsAreHarmless(files, "c.mhd", detached, detached.size(), in("c.mhd"), 124);
}

// Known: voxels and axes equal the header of three dimensions; the fourth dimension is a single time.
TEST(IngestMetaImage, FourDimensionsWithAnAxisOfLength1_areTheVolume) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::i16, 131);
  const auto written = [&](const std::string& fields) {
    return files.write("n.mha",
                       "ObjectType = Image\n" + fields +
                           "ElementType = MET_SHORT\nBinaryDataByteOrderMSB = True\nElementDataFile = LOCAL\n" +
                           volume.stored(true));
  };
  const std::string last =
      "NDims = 4\nDimSize = 5 4 3 1\nElementSpacing = 1 2 3 9\nOffset = 1 2 3 9\nCenterOfRotation = 0 0 0 0\n"
      "TransformMatrix = 0 1 0 0 1 0 0 0 0 0 1 0 0 0 0 1\n";
  expectReadsBack(volume, written(last), 132);
  const glm::dmat4 affine = {{0, 1, 0, 0}, {2, 0, 0, 0}, {0, 0, 3, 0}, {1, 2, 3, 1}};
  EXPECT_TRUE(openSource(written(last))->info().geometry.world_from_index == affine);
  expectReadsBack(volume, written("NDims = 4\nDimSize = 1 5 4 3\n"), 133);
  expectReadsBack(volume, written("NDims = 5\nDimSize = 5 4 3 1 1\nElementSpacing = 1 2 3 1 1\n"), 134);
  expectRefused(written("NDims = 4\nDimSize = 5 2 2 3\n"), ErrorCode::kUnsupported, "4-D");
  expectRefused(written("NDims = 4\nDimSize = 5 4 3 1\nElementSpacing = 1 2 3\n"), ErrorCode::kFormat,
                "4 are expected");
  expectRefused(written("NDims = 4\nDimSize = 5 4 3 1\nTransformMatrix = 1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1\n"),
                ErrorCode::kUnsupported, "mixes");
}

// Known: the stream's length plus one byte; CompressedDataSize is the stream's own length.
TEST(IngestMetaImage, ByteBehindCompressedDataSize_isNoted) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 135);
  const std::string stream = zlibbed(volume.stored(true));
  const std::string header = metaImageHeader(
      volume, true,
      "CompressedData = True\nCompressedDataSize = " + std::to_string(stream.size()) + "\nElementDataFile = LOCAL\n");
  const auto source = openSource(files.write("a.mha", header + stream + "x"));
  std::vector<std::byte> voxels(volume.voxels.size());
  source->read(boxOf(volume.dims), voxels);
  EXPECT_TRUE(voxels == volume.voxels);
  source->finish();
  EXPECT_EQ(source->info().notes, std::vector<std::string>{"a.mha: 1 byte behind the compressed data not read"});
}

TEST(IngestMetaImage, RealFileAgreesWithItsNrrdHeader) {
  // Known: the two headers describe the same bytes.
  if (realData("raw/brainsmall_128x128x84_u8.mhd").empty()) GTEST_SKIP() << "../shared/data is not here";
  const auto meta = openSource(realData("raw/brainsmall_128x128x84_u8.mhd"));
  const auto nrrd = openSource(realData("raw/brainsmall_128x128x84_u8.nhdr"));
  EXPECT_EQ(meta->info().geometry.dims, nrrd->info().geometry.dims);
  EXPECT_TRUE(meta->info().geometry.world_from_index == nrrd->info().geometry.world_from_index);
  EXPECT_TRUE(readWhole(*meta) == readWhole(*nrrd));
}

}  // namespace
}  // namespace kiln::test
