// NRRD, written here as text and bytes by the format's definition, and real files with known contents.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "ingest/open_source.h"
#include "support/files/foreign_files.h"
#include "support/files/packed_bytes.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr const char* kNrrdTypes[] = {"uint8", "signed char", "unsigned short int", "short", "uint32_t", "signed int",
                                      "float", "double"};

std::string nrrdHeader(const ForeignVolume& volume, bool big_endian, const std::string& more) {
  const Extent3& n = volume.dims;
  return "NRRD0005\n# comment: with a colon\ntype: " + std::string(kNrrdTypes[static_cast<int>(volume.type)]) +
         "\ndimension: 3\nsizes: " + std::to_string(n.x) + " " + std::to_string(n.y) + " " + std::to_string(n.z) +
         "\nkey:=a value: of the user's\ntype:=short\nitk: a:b:=c\nendian: " + (big_endian ? "big" : "little") + "\n" +
         more;
}

std::string withCrLf(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '\n' ? std::string("\r\n") : std::string(1, c);
  return out;
}

std::string inHex(const std::string& bytes) {
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const auto byte = static_cast<unsigned char>(bytes[i]);
    out += i % 2 == 0 ? fmt::format("{:02x}", byte) : fmt::format("{:02X}", byte);
    if (i % 35 == 34) out += "\n";
  }
  return out + "\n";
}

void expectAffine(const SourceInfo& info, const glm::dmat4& expected) {
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r) EXPECT_EQ(info.geometry.world_from_index[c][r], expected[c][r]) << c << "," << r;
  }
}

TEST(IngestNrrd, EveryTypeOrderEncodingAndPlaceReadsBack) {
  // Known: the test writes the bytes. The prefixes "ab\ncd\n" and "xyz" are skipped by the two skip fields.
  const ForeignFiles files;
  for (const VoxelType type : kAllTypes) {
    for (const bool big : {false, true}) {
      const ForeignVolume volume = randomVolume({13, 9, 7}, type, 61);
      const std::string bytes = volume.stored(big);
      const auto check = [&](const std::filesystem::path& path) {
        SCOPED_TRACE(path.string() + " " + std::string(nameOf(type)) + (big ? " big" : " little"));
        expectReadsBack(
            volume, [&] { return openSource(path); }, 62);
      };
      const std::string skips = "line skip: 2\nbyteskip: 3\n";
      check(files.write("raw.nrrd", nrrdHeader(volume, big, "encoding: raw\n\n") + bytes));
      check(files.write("crlf.nrrd", withCrLf(nrrdHeader(volume, big, "encoding: raw\n\n")) + bytes));
      check(files.write("gz.nrrd", nrrdHeader(volume, big, "encoding: gz\n\n") + gzipped(bytes)));
      check(files.write("two.nrrd", nrrdHeader(volume, big, "encoding: gzip\n\n") + gzipped(bytes.substr(0, 9)) +
                                        gzipped(bytes.substr(9)) + std::string(5, '\0')));
      check(files.write("bz2.nrrd", nrrdHeader(volume, big, "encoding: bzip2\n\n") + bzipped(bytes)));
      check(files.write("twobz2.nrrd", nrrdHeader(volume, big, "encoding: bz2\n\n") + bzipped(bytes.substr(0, 9)) +
                                           bzipped(bytes.substr(9))));
      check(files.write("hex.nrrd", nrrdHeader(volume, big, "encoding: hex\n\n") + inHex(bytes)));
      for (const char* separator : {" \n", ", "})
        check(files.write("text.nrrd", nrrdHeader(volume, big, "encoding: ascii\n\n") + decimalsOf(volume, separator)));
      files.write("skip.raw", "ab\ncd\nxyz" + bytes);
      check(files.write("skip.nhdr", nrrdHeader(volume, big, skips + "encoding: raw\ndatafile: ./skip.raw\n")));
      files.write("skip.gz", "ab\ncd\n" + gzipped("xyz" + bytes));
      check(files.write("skipgz.nhdr", nrrdHeader(volume, big, skips + "encoding: gzip\ndata file: skip.gz")));
      check(files.write("end.nhdr", nrrdHeader(volume, big, "byte skip: -1\nencoding: raw\ndata file: skip.raw\n")));
    }
  }
}

// Known: 500 um are half a millimetre.
TEST(IngestNrrd, UnitsOfAxes_AreConvertedToTheUnitOfX) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 72);
  SourceInfo info;
  const auto open = [&](const std::string& fields, const SourceOptions& options = {}) {
    info = openSource(
               files.write("g.nrrd", nrrdHeader(volume, false, fields + "encoding: raw\n\n") + volume.stored(false)),
               options)
               ->info();
  };
  const std::string axes = "units: \"mm\" \"mm\" \"um\"\nspacings: 0.5 0.25 500\naxis mins: 1 2 3000\n";
  open(axes);
  expectAffine(info, {{0.5, 0, 0, 0}, {0, 0.25, 0, 0}, {0, 0, 0.5, 0}, {1, 2, 3, 1}});
  EXPECT_EQ(info.geometry.unit, "mm");
  EXPECT_TRUE(info.notes.empty());
  SourceOptions options;
  options.spacing = glm::dvec3(2, 3, 4);
  open(axes, options);
  EXPECT_EQ(info.geometry.spacing(), glm::dvec3(2, 3, 4));
  open(
      "space dimension: 3\nspace units: \"mm\" \"mm\" \"um\"\n"
      "space directions: (0,0,500) (0,0.5,250) (2,0,0)\nspace origin: (1,2,3000)\n");
  expectAffine(info, {{0, 0, 0.5, 0}, {0, 0.5, 0.25, 0}, {2, 0, 0, 0}, {1, 2, 3, 1}});
  open("units: \"mm\" \"mm\" \"furlong\"\nspacings: 1 2 3\n");
  EXPECT_EQ(info.geometry.spacing(), glm::dvec3(1, 2, 3));
  ASSERT_EQ(info.notes.size(), 1u);
  EXPECT_NE(info.notes[0].find("along z are in 'furlong' and along x in 'mm'"), std::string::npos) << info.notes[0];
}

TEST(IngestNrrd, UnitsHaveTheirShortNames) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 73);
  for (const auto& [written, unit] : {std::pair{"\xc2\xb5m", "um"}, {"micron", "um"}, {"furlong", "furlong"}}) {
    const std::string units = fmt::format("units: \"{0}\" \"{0}\" \"{0}\"\nencoding: raw\n\n", written);
    const auto path = files.write("g.nrrd", nrrdHeader(volume, false, units) + volume.stored(false));
    EXPECT_EQ(openSource(path)->info().geometry.unit, unit);
  }
}

TEST(IngestNrrd, GeometryIsAsTheFormatSays) {
  // Known: columns of the affine are the directions, its last column the origin; -x is left in RAS.
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 71);
  const auto open = [&](const std::string& fields) {
    return openSource(
        files.write("g.nrrd", nrrdHeader(volume, false, fields + "encoding: raw\n\n") + volume.stored(false)));
  };
  const std::string axes = "space directions: (1,2,0.5) (0, -3 ,0) (0.25,0,4e0)\nspace origin: (10,-20,30.5)\n";
  const glm::dmat4 affine = {{1, 2, 0.5, 0}, {0, -3, 0, 0}, {0.25, 0, 4, 0}, {10, -20, 30.5, 1}};
  const glm::dmat4 mirrored = {{-1, 2, 0.5, 0}, {0, -3, 0, 0}, {-0.25, 0, 4, 0}, {-10, -20, 30.5, 1}};
  const auto ras = open("space: Right-Anterior-Superior\nspace units: \"mm\" \"mm\" \"mm\"\n" + axes);
  expectAffine(ras->info(), affine);
  EXPECT_EQ(ras->info().geometry.frame, PatientFrame::kRas);
  EXPECT_EQ(ras->info().geometry.unit, "mm");
  const auto lps = open("space: LPS\nmeasurement frame: (1,0,0) (0,1,0) (0,0,1)\n" + axes);
  expectAffine(lps->info(), affine);
  EXPECT_EQ(lps->info().geometry.frame, PatientFrame::kLps);
  const auto las = open("space: left-anterior-superior\n" + axes);
  expectAffine(las->info(), mirrored);
  EXPECT_EQ(las->info().geometry.frame, PatientFrame::kRas);
  EXPECT_EQ(open("space dimension: 3\n" + axes)->info().geometry.frame, PatientFrame::kUnknown);
  const auto axis = open("spacings: 0.5 nan 2\naxis mins: 1 nan 3\ncenters: cell node node\n");
  expectAffine(axis->info(), {{0.5, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 2, 0}, {1.25, 0, 3, 1}});
  const auto range = open("axis mins: 0 0 0\naxis maxs: 8 6 6\ncenters: node node cell\n");
  expectAffine(range->info(), {{2, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 2, 0}, {0, 0, 1, 1}});
  SourceOptions options;
  options.spacing = glm::dvec3(2, 3, 4);
  const auto plain = files.write("p.nrrd", nrrdHeader(volume, false, "encoding: raw\n\n") + volume.stored(false));
  expectAffine(openSource(plain, options)->info(), {{2, 0, 0, 0}, {0, 3, 0, 0}, {0, 0, 4, 0}, {0, 0, 0, 1}});
  const auto own = files.write("o.nrrd", nrrdHeader(volume, false, axes + "encoding: raw\n\n") + volume.stored(false));
  expectRefused(own, ErrorCode::kUsage, "--spacing", options);
}

// Known: the voxels are cut into files of whole slices. Each file begins with bytes that the header skips.
TEST(IngestNrrd, ListAndPatternOfFilesReadBack) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({13, 9, 12}, VoxelType::u16, 71);
  const std::string bytes = volume.stored(true);
  for (const std::size_t count : {12u, 4u}) {
    std::string list, packed;
    const std::size_t length = bytes.size() / count;
    for (std::size_t i = 0; i < count; ++i) {
      const std::string part = bytes.substr(i * length, length), number = fmt::format("{:03}", 7 + 2 * i);
      files.write("s" + number + ".raw", "skip" + part);
      files.write("s" + number + ".gz", gzipped(part));
      list += "./s" + number + ".raw\n";
      packed += "s" + number + ".gz\n";
    }
    const std::string raw = "byte skip: 4\nencoding: raw\ndata file: ", last = std::to_string(5 + 2 * count);
    const auto path = files.write("list.nhdr", nrrdHeader(volume, true, raw + "LIST\n" + list));
    expectReadsBack(volume, path, 72);
    EXPECT_EQ(openSource(path)->order(), ReadOrder::kAnyBox);
    EXPECT_EQ(openSource(path)->info().files.size(), count + 1);
    expectReadsBack(volume, files.write("deep.nhdr", nrrdHeader(volume, true, raw + "LIST 2\r\n" + list)), 73);
    expectReadsBack(volume, files.write("a.nhdr", nrrdHeader(volume, true, raw + "s%03d.raw 7 " + last + " 2\n")), 74);
    expectReadsBack(
        volume,
        files.write("end.nhdr", nrrdHeader(volume, true,
                                           "byte skip: -1\nencoding: raw\ndata file: s%03d.raw 7 " + last + " 2 2\n")),
        75);
    expectReadsBack(volume,
                    files.write("gz.nhdr", nrrdHeader(volume, true, "encoding: gzip\ndata file: LIST\n" + packed)), 76);
  }
}

TEST(IngestNrrd, FileOfAListThatIsShortOrMissing_isNamed) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({5, 4, 6}, VoxelType::u8, 81);
  const std::string list = nrrdHeader(volume, false, "encoding: raw\ndata file: LIST\na\nb\nc\n");
  const auto path = files.write("l.nhdr", list);
  files.write("a", std::string(40, 'a')), files.write("c", std::string(40, 'c'));
  expectRefused(path, ErrorCode::kNotFound, "the data file 'b' is missing");
  files.write("b", std::string(39, 'b'));
  expectRefused(path, ErrorCode::kFormat, "b: the file has 39 bytes, but the header's dimensions need 40");
  files.write("b", std::string(41, 'b'));
  EXPECT_EQ(openSource(path)->info().notes,
            std::vector<std::string>{"b: 1 byte behind the header's dimensions not read"});
  files.write("l.nhdr", list + "d\n");
  files.write("d", std::string(40, 'd'));
  expectRefused(path, ErrorCode::kFormat, "names 4 data files for 6 slices");
}

TEST(IngestNrrd, CutTextAndPackedData_areNoticed) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::i16, 91);
  const std::string bytes = volume.stored(false);
  const auto path = files.directory() / "c.nrrd";
  for (const std::string& whole : {nrrdHeader(volume, false, "encoding: bzip2\n\n") + bzipped(bytes),
                                   nrrdHeader(volume, false, "encoding: hex\n\n") + inHex(bytes)}) {
    expectNoCutGoesUnnoticed(volume, files, "c.nrrd", whole, path);
  }
  // A number that is cut short is a number; the missing line end is noted.
  const ForeignVolume pair = {{2, 1, 1}, VoxelType::i16, {}};
  const std::string header = nrrdHeader(pair, false, "encoding: ascii\n\n");
  const auto notesOf = [&](const std::string& numbers) {
    const auto source = openSource(files.write("c.nrrd", header + numbers));
    readWhole(*source);
    return source->info().notes;
  };
  EXPECT_TRUE(notesOf("1 300\n").empty());
  ASSERT_EQ(notesOf("1 30").size(), 1u);
  EXPECT_NE(notesOf("1 30")[0].find("its last number may be cut short"), std::string::npos);
  ASSERT_EQ(notesOf("1 30 7").size(), 1u);
  EXPECT_NE(notesOf("1 30 7")[0].find("not read, from byte"), std::string::npos);
  expectRefused(files.write("c.nrrd", header + "1\n"), ErrorCode::kFormat, "the numbers end here");
  expectRefused(files.write("c.nrrd", header + "1 40000\n"), ErrorCode::kFormat, "'40000' is not a value of type i16");
  expectRefused(files.write("c.nrrd", header + "1 2.5\n"), ErrorCode::kFormat, "'2.5' is not a value of type i16");
  expectRefused(files.write("c.nrrd", header + "1 " + std::string(5000, '1')), ErrorCode::kFormat, "too long");
}

// Known from scanf, by which teem reads text.
TEST(IngestNrrd, TextBelowTheSmallestFloat_IsZero) {
  const ForeignFiles files;
  for (const VoxelType type : {VoxelType::f32, VoxelType::f64}) {
    const ForeignVolume pair = {{2, 1, 1}, type, {}};
    const std::string header = nrrdHeader(pair, false, "encoding: ascii\n\n");
    const auto path = files.write("a.nrrd", header + "1e-999 -1.5E-99999\n");
    withVoxelType(type, [&]<class T>(std::type_identity<T>) {
      T found[2];
      const std::vector<std::byte> voxels = readWhole(*openSource(path));
      ASSERT_EQ(voxels.size(), sizeof found);
      std::memcpy(found, voxels.data(), sizeof found);
      EXPECT_EQ(found[0], T{0});
      EXPECT_EQ(found[1], T{0});
    });
    expectRefused(files.write("b.nrrd", header + "1 1e999\n"), ErrorCode::kFormat, "'1e999' is not a value of type");
  }
}

TEST(IngestNrrd, WhatIsNotReadIsRefusedByName) {
  // Known: each header is legal, or wrong in exactly the field that the message must name.
  const ForeignFiles files;
  const auto refused = [&](const std::string& text, ErrorCode code, const std::string& part) {
    expectRefused(files.write("r.nrrd", "NRRD0004\n" + text + "\n" + std::string(64, 'x')), code, part);
  };
  const std::string base = "dimension: 3\nsizes: 2 2 2\n", u8 = "type: uchar\n" + base;
  refused(u8 + "encoding: bzip2\n", ErrorCode::kFormat, "damaged");
  refused(u8 + "encoding: text\n", ErrorCode::kFormat, "is not a value of type u8");
  refused(u8 + "encoding: hex\n", ErrorCode::kFormat, "is no hexadecimal digit");
  refused(u8 + "encoding: zip\n", ErrorCode::kFormat, "'zip' is not an encoding");
  refused("type: block\n" + base + "encoding: raw\n", ErrorCode::kUnsupported, "block");
  refused("type: quux\n" + base + "encoding: raw\n", ErrorCode::kFormat, "quux");
  refused("type: short\n" + base + "encoding: raw\n", ErrorCode::kFormat, "endian");
  refused("type: uchar\ndimension: 2\nsizes: 2 2\nencoding: raw\n", ErrorCode::kUnsupported, "2-D");
  refused("type: uchar\ndimension: 4\nsizes: 3 2 2 2\nencoding: raw\n", ErrorCode::kUnsupported, "4-D");
  const std::string vectors = "vector, tensor or colour data";
  refused("type: uchar\ndimension: 4\nkinds: vector domain domain domain\nsizes: 3 2 2 2\nencoding: raw\n",
          ErrorCode::kUnsupported, vectors);
  refused(u8 + "kinds: RGB-color domain domain\nencoding: raw\n", ErrorCode::kUnsupported, vectors);
  refused(u8 + "encoding: raw\ndata file: LIST\na.raw\n", ErrorCode::kNotFound, "the data file 'a.raw' is missing");
  refused(u8 + "encoding: raw\ndata file: a%03d.raw 1 9 1\n", ErrorCode::kNotFound, "'a001.raw' is missing");
  for (const char* pattern : {"a%s.raw", "a%d%d.raw", "a%99d.raw", "a%n.raw", "a%"})
    refused(u8 + "encoding: raw\ndata file: " + pattern + " 1 9 1\n", ErrorCode::kFormat, "is no pattern");
  for (const char* count :
       {"1 9 0", "9 1 1", "1 0 2", "0 1 -2", "1 9000000000 1", "-9223372036854775808 9223372036854775807 1"})
    refused(u8 + "encoding: raw\ndata file: a%d.raw " + count + "\n", ErrorCode::kFormat, "counts no files");
  // A list at the end of the header.
  expectRefused(files.write("empty.nhdr", "NRRD0004\n" + u8 + "encoding: raw\ndata file: LIST 2\n"), ErrorCode::kFormat,
                "the list names no data file");
  refused(u8 + "encoding: raw\ndata file: gone.raw\n", ErrorCode::kNotFound, "gone.raw");
  refused(u8 + "encoding: raw\nsizes: 2 2 2\n", ErrorCode::kFormat, "line 6: sizes");
  refused(u8 + "encoding: raw\nspace: LPS\nspace dimension: 3\n", ErrorCode::kFormat, "line 7");
  refused(u8 + "encoding: raw\nspacings: 1 1 1\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n", ErrorCode::kFormat,
          "contradicts");
  refused(u8 + "encoding: raw\nspace directions: (1,0,0) (0,1,0) (0,2,0)\n", ErrorCode::kFormat, "do not span");
  refused(u8 + "encoding: raw\nspacings: 1 0 1\n", ErrorCode::kFormat, "do not span");
  refused("type: uchar\ndimension: 3\nsizes: 9999999 9999999 9999999\nencoding: raw\n", ErrorCode::kFormat, "2^63");
  refused("type: uchar\ndimension: 3\nsizes: 2 2 -2\nencoding: raw\n", ErrorCode::kFormat, "-2 voxels");
  refused("type: uchar\ndimension: 3\nsizes: 5 5 5\nencoding: raw\n", ErrorCode::kFormat, "need 125");
  refused("type: uchar\ndimension: 3\nsizes: 999 999 999\nencoding: gzip\n", ErrorCode::kFormat, "997002999");
}

TEST(IngestNrrd, StreamsThatAreCutOrDamagedAreRefused) {
  // Known: a voxel is missing, or a checksum is wrong; each is a single change to a good file.
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 81);
  const std::string head = nrrdHeader(volume, false, "encoding: gzip\n\n"), bytes = volume.stored(false);
  const auto refused = [&](const std::string& stream, const std::string& part) {
    expectRefused(files.write("s.nrrd", head + stream), ErrorCode::kFormat, part);
  };
  refused(gzipped(bytes.substr(1)), "slice 2");
  std::string wrong = gzipped(bytes);
  wrong[wrong.size() - 8] ^= 1;
  refused(wrong, "damaged");
}

// As for raw files: the voxels are whole, and a note names the unread bytes. The checksum is still tested.
TEST(IngestNrrd, BytesBehindCompressedVoxels_areNoted) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 82);
  const std::string head = nrrdHeader(volume, false, "encoding: gzip\n\n"), bytes = volume.stored(false);
  const auto notesOf = [&](const std::string& stream) {
    const auto source = openSource(files.write("s.nrrd", head + stream));
    std::vector<std::byte> voxels(volume.voxels.size());
    source->read(boxOf(volume.dims), voxels);
    EXPECT_TRUE(voxels == volume.voxels);
    source->finish();
    return source->info().notes;
  };
  using Notes = std::vector<std::string>;
  EXPECT_EQ(notesOf(gzipped(bytes)), Notes());
  EXPECT_EQ(notesOf(gzipped(bytes) + std::string(9, '\0')), Notes()) << "zeros are padding, as for gzip";
  EXPECT_EQ(notesOf(gzipped(bytes) + "t"), Notes{"s.nrrd: 1 byte behind the compressed data not read"});
  EXPECT_EQ(notesOf(gzipped(bytes + std::string(100'000, 'x'))),
            Notes{"the compressed data of s.nrrd hold 100000 bytes more than the header's dimensions need, which are "
                  "not read"});
  std::string wrong = gzipped(bytes + "x");
  wrong[wrong.size() - 8] ^= 1;
  expectRefused(files.write("s.nrrd", head + wrong), ErrorCode::kFormat, "damaged");
}

// Known: voxels and axes equal the header of three dimensions; a single component, a single time, or both.
TEST(IngestNrrd, MoreThanThreeDimensionsWithAxesOfLength1_areTheVolume) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::i16, 83);
  const glm::dmat4 affine = {{1, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 3, 0}, {1, 2, 3, 1}};
  const std::string start = "NRRD0005\ntype: int16\nendian: big\n";
  const auto written = [&](const std::string& header, const std::string& encoding) {
    const std::string bytes = volume.stored(true);
    return files.write(
        "n.nrrd", start + header + "encoding: " + encoding + "\n\n" + (encoding == "raw" ? bytes : gzipped(bytes)));
  };
  const std::string headers[] = {
      "dimension: 4\nsizes: 1 5 4 3\nkinds: list domain domain domain\nspace: LPS\n"
      "space directions: none (1,0,0) (0,2,0) (0,0,3)\nspace origin: (1,2,3)\n",
      "dimension: 4\nsizes: 5 4 3 1\nspace: LPS\nspace directions: (1, 0, 0) (0,2,0) (0,0,3) none\n"
      "space origin: (1,2,3)\n",
      "dimension: 4\nsizes: 5 4 3 1\nspacings: 1 2 3 nan\naxis mins: 1 2 3 0\ncenters: node node node cell\n"
      "units: \"mm\" \"mm\" \"mm\" \"s\"\nlabels: \"x\" \"the y\" \"z\" \"(t\"\nkinds: space space space time\n",
      "dimension: 5\nsizes: 1 5 4 3 1\nkinds: vector domain domain domain time\nspacings: nan 1 2 3 40\n"
      "axis mins: nan 1 2 3 nan\n"};
  for (const std::string& header : headers) {
    SCOPED_TRACE(header);
    for (const char* encoding : {"raw", "gzip"}) {
      const auto path = written(header, encoding);
      expectReadsBack(volume, path, 84);
      expectAffine(openSource(path)->info(), affine);
    }
  }
  EXPECT_EQ(openSource(written(headers[2], "raw"))->info().geometry.unit, "mm");
  // A slice: `kinds` selects the spatial axis among two axes of length 1.
  const auto slice = written("dimension: 4\nsizes: 1 60 1 1\nkinds: list domain domain domain\n", "raw");
  EXPECT_EQ(openSource(slice)->info().geometry.dims, (Extent3{60, 1, 1}));
  expectRefused(written("dimension: 4\nsizes: 2 5 2 3\n", "raw"), ErrorCode::kUnsupported, "4-D");
  expectRefused(written("dimension: 4\nsizes: 1 5 4 3\nspacings: 1 2 3\n", "raw"), ErrorCode::kFormat,
                "4 are expected");
  for (const std::string& header : headers) {
    const std::string whole = start + header + "encoding: raw\n\n";
    expectNoCutGoesUnnoticed(volume, files, "c.nrrd", whole + volume.stored(true), files.directory() / "c.nrrd");
    expectBitFlipsAreHarmless(files, "c.nrrd", whole + volume.stored(true), whole.size(), files.directory() / "c.nrrd",
                              85);
  }
}

TEST(IngestNrrd, NarrowFirstAxisWithoutKinds_isNoted) {
  const ForeignFiles files;
  const auto notes = [&](const std::string& more) {
    return openSource(files.write("c.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 20 20\nencoding: raw\n" +
                                                more + "\n" + std::string(1200, 'x')))
        ->info()
        .notes;
  };
  ASSERT_EQ(notes("").size(), 1u);
  EXPECT_NE(notes("")[0].find("colours"), std::string::npos);
  EXPECT_TRUE(notes("kinds: domain domain domain\n").empty());
}

// Known: a negative spacing is legal, but more often an error than a mirrored scan.
TEST(IngestNrrd, NegativeSpacing_isNoted) {
  const ForeignFiles files;
  const auto notes = [&](const std::string& more) {
    return openSource(files.write("a.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n" +
                                                more + "\n12345678"))
        ->info()
        .notes;
  };
  EXPECT_TRUE(notes("spacings: 1 2 3\n").empty());
  ASSERT_EQ(notes("spacings: 1 -2 -3\n").size(), 1u);
  EXPECT_NE(notes("spacings: 1 -2 -3\n")[0].find("negative along y, z"), std::string::npos);
}

// Known: the header describes a smaller volume than the data; its own bytes are legal.
TEST(IngestNrrd, BytesBehindTheVolumeAreToldOf) {
  const ForeignFiles files;
  const std::string header = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n";
  EXPECT_TRUE(openSource(files.write("a.nrrd", header + "\n12345678"))->info().notes.empty());
  const auto notes = openSource(files.write("b.nrrd", header + "\n12345678123"))->info().notes;
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("b.nrrd: 3 bytes behind the header's dimensions"), std::string::npos) << notes[0];
  files.write("a.nhdr", header + "data file: \xc3\xa4\x1b[1m.raw\n");
  expectRefused(files.directory() / "a.nhdr", ErrorCode::kNotFound, "\xc3\xa4");
}

TEST(IngestNrrd, EveryCutIsNoticedAndFlipsAreHarmless) {
  // Known: lengths and checksums leave no cut that holds all voxels; the data file's name is the header's last line.
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::i16, 91);
  const std::string bytes = volume.stored(true), geometry = "spacings: 1 1 2.5\nspace origin: (1,2,3)\n";
  const std::string raw = nrrdHeader(volume, true, geometry + "encoding: raw\n\n"),
                    gz = nrrdHeader(volume, true, "encoding: gzip\n\n");
  const std::string detached =
      nrrdHeader(volume, true, geometry + "byte skip: -1\nencoding: raw\ndata file: data.raw\n");
  files.write("data.raw", bytes);
  const auto in = [&](const char* name) { return files.directory() / name; };
  expectNoCutGoesUnnoticed(volume, files, "a.nrrd", raw + bytes, in("a.nrrd"));
  expectNoCutGoesUnnoticed(volume, files, "b.nrrd", gz + gzipped(bytes), in("b.nrrd"));
  expectNoCutGoesUnnoticed(volume, files, "c.nhdr", detached, in("c.nhdr"));
  expectNoCutGoesUnnoticed(volume, files, "data.raw", bytes, in("c.nhdr"));
  expectBitFlipsAreHarmless(files, "a.nrrd", raw + bytes, raw.size(), in("a.nrrd"), 92);
  expectBitFlipsAreHarmless(files, "b.nrrd", gz + gzipped(bytes), gz.size() + 20, in("b.nrrd"), 93);
  expectBitFlipsAreHarmless(files, "c.nhdr", detached, detached.size(), in("c.nhdr"), 94);
}

template <class T>
std::pair<double, double> rangeOf(const std::vector<std::byte>& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  const auto [lo, hi] = std::minmax_element(values.begin(), values.end());
  return {static_cast<double>(*lo), static_cast<double>(*hi)};
}

TEST(IngestNrrd, RealVolumesAreWhatTheirDescriptionSays) {
  // Known: dimensions, types, spacings and cthead's range are in the data's README, written from other tools.
  struct Known {
    const char* name;
    Extent3 dims;
    VoxelType type;
    glm::dvec3 spacing;
  };
  if (realData("cthead_256x256x113_u16le.nrrd").empty()) GTEST_SKIP() << "../shared/data is not here";
  for (const Known& known : {Known{"cthead_256x256x113_u16le.nrrd", {256, 256, 113}, VoxelType::u16, {1, 1, 2}},
                             Known{"mrbrain_256x256x109_u16le.nrrd", {256, 256, 109}, VoxelType::u16, {1, 1, 1.5}},
                             Known{"vhm_head_512x512x245_i16le.nrrd", {512, 512, 245}, VoxelType::i16, {1, 1, 1}}}) {
    SCOPED_TRACE(known.name);
    const auto source = openSource(realData(known.name));
    EXPECT_EQ(source->info().geometry.dims, known.dims);
    EXPECT_EQ(source->info().type, known.type);
    EXPECT_EQ(source->info().geometry.spacing(), known.spacing);
    const std::vector<std::byte> voxels = readWhole(*source);
    if (std::string(known.name).starts_with("cthead")) {
      EXPECT_EQ(rangeOf<std::uint16_t>(voxels), (std::pair{0.0, 3272.0}));
    }
  }
  const auto fetal = openSource(realData("fetal_template_T2.nrrd"));
  EXPECT_EQ(fetal->info().geometry.frame, PatientFrame::kLps);
  EXPECT_EQ(fetal->info().type, VoxelType::f32);
  EXPECT_EQ(fetal->info().geometry.dims, (Extent3{117, 159, 126}));
  const double edge = 0.859375;
  expectAffine(fetal->info(),
               {{edge, 0, 0, 0}, {0, edge, 0, 0}, {0, 0, edge, 0}, {-49.84375, 67.890625, -53.7109375, 1}});
  readWhole(*fetal);
}

// NaN means "unknown" in NRRD's definition.
TEST(IngestNrrd, UnknownSpacing_isSaid) {
  const std::filesystem::path file = freshDirectory("nrrd_nan") / "a.nrrd";
  const auto open = [&](const std::string& spacings, const SourceOptions& options = {}) {
    writeText(file, "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspacings: " + spacings +
                        "\nencoding: raw\n\nabcdefgh");
    return openSource(file, options);
  };
  const auto unknown = open("nan 2 nan");
  EXPECT_EQ(unknown->info().geometry.spacing(), glm::dvec3(1, 2, 1));
  ASSERT_EQ(unknown->info().notes.size(), 1u);
  EXPECT_NE(unknown->info().notes[0].find("unknown (nan) along x, z, and taken as 1"), std::string::npos);
  EXPECT_TRUE(open("1 2 1")->info().notes.empty());
  SourceOptions given;
  given.spacing = glm::dvec3(3, 2, 1);
  EXPECT_TRUE(open("nan 2 nan", given)->info().notes.empty());
}

TEST(IngestNrrd, RealRawAndDetachedHeaderAgree) {
  // Known: both headers describe the same bytes.
  if (realData("raw/engine.nhdr").empty()) GTEST_SKIP() << "../shared/data is not here";
  SourceOptions options;
  options.dims = Extent3{149, 208, 110};
  options.type = VoxelType::u8;
  EXPECT_TRUE(readWhole(*openSource(realData("raw/engine.raw"), options)) ==
              readWhole(*openSource(realData("raw/engine.nhdr"))));
}

}  // namespace
}  // namespace kiln::test
