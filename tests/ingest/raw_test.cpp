// Headerless raw data and the dispatch by content. The answers are known because the test wrote the bytes.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstring>

#include "ingest/bytes/linear_source.h"
#include "ingest/open_source.h"
#include "support/files/foreign_files.h"

namespace kiln::test {
namespace {

SourceOptions optionsOf(const ForeignVolume& volume, bool big_endian = false, std::uint64_t skip = 0) {
  SourceOptions options;
  options.dims = volume.dims;
  options.type = volume.type;
  options.big_endian = big_endian;
  options.skip_bytes = skip;
  return options;
}

TEST(IngestRaw, EveryTypeAndByteOrderReadsBack) {
  // Known: the file is the volume's own bytes, reversed by hand for the other byte order, after a prefix to skip.
  const ForeignFiles files;
  for (const VoxelType type : kAllTypes) {
    for (const bool big_endian : {false, true}) {
      for (const std::uint64_t skip : {0u, 13u}) {
        SCOPED_TRACE(std::string(nameOf(type)) + (big_endian ? " big" : " little"));
        const ForeignVolume volume = randomVolume({13, 9, 7}, type, 11);
        const auto path = files.write("v.raw", std::string(skip, 'x') + volume.stored(big_endian));
        expectReadsBack(
            volume, [&] { return openSource(path, optionsOf(volume, big_endian, skip)); }, 12);
      }
    }
  }
}

TEST(IngestRaw, BoxesLargerThanAChunkReadBack) {
  // Known: as above. Rows of 600 bytes at distances of 1000 and slices above 1 MiB take more than one merged read.
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({500, 1200, 3}, VoxelType::u16, 21);
  const auto path = files.write("v.raw", volume.stored(false));
  const auto source = openSource(path, optionsOf(volume));
  for (const VoxelBox& box : {VoxelBox{{100, 0, 0}, {400, 1200, 3}}, VoxelBox{{0, 100, 0}, {500, 1100, 3}},
                              VoxelBox{{7, 3, 1}, {307, 1199, 3}}, VoxelBox{{9, 3, 1}, {10, 1199, 3}}}) {
    std::vector<std::byte> out(static_cast<std::size_t>(box.count()) * 2);
    source->read(box, out);
    EXPECT_TRUE(out == volume.box(box));
  }
}

TEST(IngestRaw, OptionsThatChooseAPart_areRefusedByFormatsWithoutParts) {
  const ForeignFiles files;
  SourceOptions channel, time, scale;
  channel.channel = "2", time.time = 0, scale.scale = 1;
  const auto nrrd = files.write("x.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\n1");
  expectRefused(nrrd, ErrorCode::kUsage, "x.nrrd: --channel: NRRD files have no channels; leave", channel);
  expectRefused(nrrd, ErrorCode::kUsage, "x.nrrd: --time: NRRD files have no times", time);
  expectRefused(nrrd, ErrorCode::kUsage, "x.nrrd: --scale: NRRD files have no scales", scale);
  expectRefused("phantom:head:8x8x8", ErrorCode::kUsage, "a phantom has no channels", channel);
}

TEST(IngestRaw, SeveralThreadsReadAtOnce) {
  // Known: as above; kAnyBox promises any thread.
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({40, 30, 20}, VoxelType::i16, 31);
  const auto path = files.write("v.raw", volume.stored(true));
  const auto source = openSource(path, optionsOf(volume, true));
  expectThreadsReadBack(volume, *source);
}

TEST(IngestRaw, LinearMapRoundsOnceAndSaturates) {
  // Known: worked out by hand; halves are exact in binary, so the values are too.
  const ForeignFiles files;
  const auto path = files.write("v.raw", std::string("\x00\x01\x02\x80\xff", 5));
  SourceInfo info;
  info.geometry.dims = {5, 1, 1};
  const LinearData data{.file = path, .stored_type = VoxelType::u8, .slope = 2.5, .intercept = -3};
  const auto mapped = [&](auto zero, VoxelType type, DataEncoding encoding) {
    info.type = type;
    LinearData from = data;
    from.encoding = encoding;
    if (encoding != DataEncoding::kRaw) from.file = files.write("v.z", zlibbed({"\x00\x01\x02\x80\xff", 5}));
    const std::vector<std::byte> bytes = readWhole(*openLinear(info, from));
    std::vector<decltype(zero)> out(5);
    std::memcpy(out.data(), bytes.data(), bytes.size());
    return out;
  };
  for (const DataEncoding encoding : {DataEncoding::kRaw, DataEncoding::kZlib}) {
    EXPECT_EQ(mapped(0.0f, VoxelType::f32, encoding), (std::vector<float>{-3, -0.5f, 2, 317, 634.5f}));
    EXPECT_EQ(mapped(std::int8_t(0), VoxelType::i8, encoding), (std::vector<std::int8_t>{-3, 0, 2, 127, 127}));
  }
}

TEST(IngestRaw, EveryCutIsNoticed) {
  // Known: the length is the only witness, and no shorter length agrees with the dimensions.
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u16, 41);
  expectNoCutGoesUnnoticed(volume, files, "v.raw", "head" + volume.stored(false), files.directory() / "v.raw",
                           optionsOf(volume, false, 4));
}

TEST(IngestRaw, WrongLengthsNameBothNumbersAndTheWayOut) {
  // Known: 5*4*3*2 = 120 bytes are expected.
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u16, 51);
  const auto longer = files.write("long.raw", std::string(7, 'x') + volume.stored(false));
  expectRefused(longer, ErrorCode::kFormat, "has 127 bytes", optionsOf(volume));
  expectRefused(longer, ErrorCode::kFormat, "takes 120", optionsOf(volume));
  expectRefused(longer, ErrorCode::kFormat, "--skip 7", optionsOf(volume));
  SourceOptions huge = optionsOf(volume);
  huge.dims = Extent3{2147483647, 2147483647, 2147483647};
  expectRefused(longer, ErrorCode::kFormat, "2^63", huge);
  huge.dims = Extent3{0, 1, 1};
  expectRefused(longer, ErrorCode::kFormat, "0 voxels", huge);
}

TEST(IngestOpen, WhatIsNotReadIsRefusedByName) {
  // Known: each file begins with the magic bytes of its format.
  const ForeignFiles files;
  const auto refused = [&](const std::string& name, std::string_view bytes, const std::string& part) {
    expectRefused(files.write(name, bytes), ErrorCode::kUnsupported, part);
  };
  using namespace std::string_view_literals;
  expectRefused(files.write("a", "II*\0\x08\0\0\0"sv), ErrorCode::kFormat, "TIFF");
  refused("b", "\x89PNG\r\n\x1a\n rest"sv, "PNG");
  refused("c", "\xff\xd8\xff\xe0"sv, "JPEG");
  refused("f", "PK\x03\x04"sv, "ZIP");
  refused("g", std::string(128, '\0') + "DICM", "no pixel data; it is a DICOM file");
  refused("h.nrrd.gz", gzipped("NRRD0004\n"), "gzip-compressed NRRD");
  refused("j.tif.gz", gzipped("II*\0\x08\0\0\0"sv), "gzip-compressed TIFF");
  refused("i.raw.gz", gzipped("anything"), "gzip-compressed");
  // The pipe has no writer: opening it would block forever.
  ASSERT_EQ(mkfifo((files.directory() / "pipe.raw").c_str(), 0600), 0);
  expectRefused(files.directory() / "pipe.raw", ErrorCode::kUnsupported, "pipe");
  const auto nhdr =
      files.write("p.nhdr", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\ndata file: pipe.raw\n");
  expectRefused(nhdr, ErrorCode::kFormat, "pipe");
}

TEST(IngestOpen, WrongUsesOfOptionsAreUsageErrors) {
  // Known: the contract of openSource.
  const ForeignFiles files;
  const auto raw = files.write("v.raw", "abcdef");
  const auto nrrd = files.write("v.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\nx");
  expectRefused(raw, ErrorCode::kUsage, "--dims and --type");
  expectRefused(raw, ErrorCode::kUsage, "--dims 256,256,113 --type u16");  // in the syntax of the command line
  SourceOptions half;
  half.dims = Extent3{4, 4, 4};
  expectRefused(raw, ErrorCode::kUsage, "--type: headerless raw voxels need a type", half);
  half = {};
  half.type = VoxelType::u16;
  expectRefused(raw, ErrorCode::kUsage, "--dims: headerless raw voxels need a size", half);
  files.write("v.nhdr", "NRRD0004\n");
  expectRefused(raw, ErrorCode::kUsage, "'v.nhdr'");
  SourceOptions options;
  options.grid_name = "density";
  expectRefused(nrrd, ErrorCode::kUsage, "--grid", options);
  options = {};
  options.dims = Extent3{1, 1, 1};
  expectRefused(nrrd, ErrorCode::kUsage, "--dims", options);
  options = {};
  options.big_endian = false;
  expectRefused(nrrd, ErrorCode::kUsage, "--endian", options);
  options = {};
  options.spacing = glm::dvec3(1, -1, 1);
  expectRefused(nrrd, ErrorCode::kUsage, "--spacing", options);
  expectRefused(files.directory() / "nothing.nrrd", ErrorCode::kNotFound, "nothing.nrrd");
  expectRefused(files.directory(), ErrorCode::kUnsupported, "'v.nhdr'");
}

}  // namespace
}  // namespace kiln::test
