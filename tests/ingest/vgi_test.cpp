// VGI. Known because the test writes the header's text and the voxels beside it.
#include <gtest/gtest.h>

#include "base/error.h"
#include "ingest/open_source.h"
#include "support/files/foreign_files.h"
#include "support/files/vgi_files.h"

namespace kiln::test {
namespace {

TEST(IngestVgi, EveryTypeReadsBack) {
  const ForeignFiles files;
  for (const VoxelType type : kAllTypes) {
    SCOPED_TRACE(nameOf(type));
    const char kind = nameOf(type)[0];
    const ForeignVolume volume = randomVolume({13, 9, 7}, type, 401);
    const std::string header = vgiHeader(volume.dims,
                                         kind == 'u'   ? "unsigned integer"
                                         : kind == 'i' ? "signed integer"
                                                       : "float",
                                         static_cast<int>(8 * sizeOf(type)));
    files.write("a.vol", volume.stored(false));
    expectReadsBack(volume, files.write("a.vgi", header), 402);
    const std::string far = replaced(header, "Name = a.vol", "SkipHeader = 5\r\nName = D:\\scans\\b.vol");
    files.write("b.vol", "12345" + volume.stored(false));
    expectReadsBack(volume, files.write("b.vgi", far), 403);
  }
}

TEST(IngestVgi, ResolutionIsTheSpacing) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 411);
  const std::string whole = vgiHeader(volume.dims, "unsigned integer", 8);
  files.write("a.vol", volume.stored(false));
  const auto path = files.write("a.vgi", whole);
  const VolumeGeometry g = openSource(path)->info().geometry;
  EXPECT_EQ(g.worldOf({2, 4, 3}), glm::dvec3(1, 3, 6));
  EXPECT_EQ(g.unit, "mm");
  SourceOptions options;
  options.spacing = glm::dvec3(2);
  expectRefused(path, ErrorCode::kUsage, "--spacing", options);
  const auto twice = files.write("c.vgi", whole + "{volumeprimitive2}\n[geometry]\nresolution = 9 9 9\n");
  const auto only_second = files.write("d.vgi", replaced(whole, "resolution = 0.5 0.75 2\n", "status = visible\n") +
                                                    "{volumeprimitive2}\n[geometry]\nresolution = 9 9 9\n");
  EXPECT_EQ(openSource(only_second)->info().geometry.worldOf({2, 4, 3}), glm::dvec3(2, 4, 3));
  EXPECT_EQ(openSource(twice)->info().geometry.worldOf({2, 4, 3}), glm::dvec3(1, 3, 6));
  const auto unplaced = files.write("b.vgi", replaced(whole, "resolution = 0.5 0.75 2\n", ""));
  EXPECT_EQ(openSource(unplaced, options)->info().geometry.worldOf({1, 1, 1}), glm::dvec3(2));
}

TEST(IngestVgi, OtherHeadersAreRefused) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 421);
  const std::string whole = vgiHeader(volume.dims, "unsigned integer", 8);
  files.write("a.vol", volume.stored(false));
  const auto refused = [&](const std::string& from, const std::string& to, ErrorCode code, const std::string& part) {
    expectRefused(files.write("a.vgi", replaced(whole, from, to)), code, part);
  };
  refused("Name = a.vol", "Name = b.vol", ErrorCode::kNotFound, "line 10: Name: the data file 'b.vol' is missing");
  refused("Name = a.vol", "Name = a.vgi", ErrorCode::kFormat, "is this header itself");
  refused("Name = a.vol\n", "", ErrorCode::kFormat, "the field 'file1/name' is missing");
  refused("FileFormat = raw", "FileFormat = VOL", ErrorCode::kUnsupported, "'VOL' is not read; save the volume as raw");
  refused("Datatype = unsigned", "Datatype = odd", ErrorCode::kUnsupported, "'odd integer' of 8 bits is not read");
  refused("BitsPerElement = 8", "BitsPerElement = 12", ErrorCode::kUnsupported, "of 12 bits is not read");
  refused("Size = 5 4 3", "Size = 5 4", ErrorCode::kFormat, "line 9: Size");
  refused("Size = 5 4 3", "Size = 5 4 -3", ErrorCode::kFormat, "-3 voxels along an axis");
  refused("Size = 5 4 3", "Size = 5 4 4", ErrorCode::kFormat, "a.vol");
  refused("Size = 5 4 3", "Size", ErrorCode::kFormat, "'Size' is not as NAME = VALUE");
  refused("Name = a.vol", "SkipHeader = -1\nName = a.vol", ErrorCode::kFormat, "SkipHeader: is negative");
  refused("resolution = 0.5", "resolution = 0", ErrorCode::kFormat, "a.vgi");
  refused("{volumeprimitive12}", "{volume2}", ErrorCode::kUnsupported, "holds several volumes");
  refused("[geometry]", "[file2]", ErrorCode::kUnsupported, "the voxels are in several files");
}

TEST(IngestVgi, EveryCutIsNoticedAndFlipsAreHarmless) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u16, 431);
  const std::string whole = vgiHeader(volume.dims, "unsigned integer", 16), voxels = volume.stored(false);
  files.write("a.vol", voxels);
  const auto path = files.write("a.vgi", whole);
  // A text has no mark at its end: behind the file's fields a cut can only lose the spacing.
  for (std::size_t length = 0; length < whole.find("\n{volumeprimitive"); ++length) {
    files.write("a.vgi", whole.substr(0, length));
    EXPECT_THROW(readWhole(*openSource(path)), Error) << "cut to " << length;
  }
  expectBitFlipsAreHarmless(files, "a.vgi", whole, whole.size(), path, 432);
  files.write("a.vgi", whole);
  expectNoCutGoesUnnoticed(volume, files, "a.vol", voxels, path);
}

}  // namespace
}  // namespace kiln::test
