// NumPy arrays. Known because the test writes the header as text and the voxels one by one, in either order.
#include <gtest/gtest.h>

#include <cstring>

#include "ingest/open_source.h"
#include "support/files/foreign_files.h"
#include "support/files/npy_files.h"

namespace kiln::test {
namespace {

constexpr NpyLayout kFortran = {.fortran_order = true};

TEST(IngestNpy, EveryTypeOrderAndVersionReadsBack) {
  const ForeignFiles files;
  for (const VoxelType type : kAllTypes) {
    const ForeignVolume volume = randomVolume({13, 9, 7}, type, 201);
    for (const bool big_endian : {false, true}) {
      for (const bool fortran_order : {false, true}) {
        for (const int version : {1, 2, 3}) {
          SCOPED_TRACE(testing::Message() << nameOf(type) << " big " << big_endian << " Fortran " << fortran_order
                                          << " version " << version);
          expectReadsBack(volume, files.write("a.npy", npyFile(volume, {version, big_endian, fortran_order})), 202);
        }
      }
    }
  }
}

// Known: as above. The boxes take several blocks of 1 MiB along x, along y and, in a long volume, along z.
TEST(IngestNpy, BoxesLargerThanABlockReadBack) {
  const ForeignFiles files;
  const auto check = [&](const Extent3& dims, const VoxelBox& box) {
    const ForeignVolume volume = randomVolume(dims, VoxelType::u16, 211);
    const auto source = openSource(files.write("a.npy", npyFile(volume, kFortran)));
    EXPECT_TRUE(readWhole(*source) == volume.voxels);
    std::vector<std::byte> out(static_cast<std::size_t>(box.count()) * 2);
    source->read(box, out);
    EXPECT_TRUE(out == volume.box(box));
  };
  check({300, 100, 70}, {{3, 1, 2}, {299, 97, 69}});
  check({3, 1200, 700}, {{1, 5, 1}, {3, 1199, 698}});
  check({2, 3, 600'000}, {{1, 1, 7}, {2, 3, 599'990}});
}

TEST(IngestNpy, SeveralThreadsReadFortranOrderAtOnce) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({40, 30, 20}, VoxelType::f64, 221);
  const auto source = openSource(files.write("a.npy", npyFile(volume, kFortran)));
  ASSERT_EQ(source->order(), ReadOrder::kAnyBox);
  expectThreadsReadBack(volume, *source);
}

// Known: each text is the same dictionary for Python's ast.literal_eval, or NumPy's form under Python 2.
TEST(IngestNpy, SpellingsOfOneHeader_areOneVolume) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u16, 231);
  for (const std::string text : {
           "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 5)}",
           "{\"shape\": (3, 4, 5,), \"fortran_order\": False, \"descr\": \"<u2\",}",
           "{'shape':(3,4,5),'descr':'<u2','fortran_order':False}",
           "  {\n'descr' :\t'<u2' ,\r\n 'fortran_order' : False , 'shape' : ( 3 , 4 , 5 , ) , } ",
           "{'descr': '<u2', 'fortran_order': False, 'shape': (3L, 4L, 5L), }",
       }) {
    SCOPED_TRACE(text);
    expectReadsBack(volume, files.write("a.npy", npyHeader(text) + volume.stored(false)), 232);
    // No writer pads to less than 16 bytes, but readers take any length.
    std::string unpadded = std::string("\x93NUMPY\x01\0", 8) + static_cast<char>(text.size()) + '\0';
    expectReadsBack(volume, files.write("a.npy", unpadded + text + volume.stored(false)), 233);
  }
}

// Known: 1.5 is 0x3e00 as a half float, and small integers have the same value in 32 and 64 bits.
TEST(IngestNpy, HalfFloatsAndWideIntegersBecomeVoxels) {
  const ForeignFiles files;
  const auto open = [&](const std::string& descr, const std::string& bytes) {
    const std::string header = npyHeader("{'descr': '" + descr + "', 'fortran_order': False, 'shape': (1, 1, 2), }");
    return openSource(files.write("a.npy", header + bytes));
  };
  const auto half = open("<f2", std::string("\0\x3e\0\xc0", 4));
  const float halves[] = {1.5f, -2.f};
  EXPECT_EQ(half->info().type, VoxelType::f32);
  EXPECT_EQ(std::memcmp(readWhole(*half).data(), halves, 8), 0);
  const auto wide = open(">i8", std::string(8, '\xff') + std::string(7, '\0') + "\7");
  const std::int32_t integers[] = {-1, 7};
  EXPECT_EQ(wide->info().type, VoxelType::i32);
  EXPECT_EQ(std::memcmp(readWhole(*wide).data(), integers, 8), 0);
  const auto large = open("<u8", std::string(16, '\xff'));
  EXPECT_EQ(large->info().type, VoxelType::u32);
  expectRefused(files.directory() / "a.npy", ErrorCode::kFormat,
                "slice 0: the 64-bit integer 18446744073709551615 does not fit into 32 bits");
}

TEST(IngestNpy, BytesHaveNoOrder) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::i8, 235);
  for (const std::string descr : {"|i1", "<i1", ">i1", "=i1", "i1"}) {
    const std::string header = npyHeader("{'descr': '" + descr + "', 'fortran_order': False, 'shape': (3, 4, 5), }");
    expectReadsBack(volume, files.write("a.npy", header + volume.stored(false)), 236);
  }
}

TEST(IngestNpy, SpacingIsTheUsersAndTheChoiceOfAxesIsNoted) {
  // Known: the axes are z, y, x in either order, and the file has no spacing.
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 241);
  for (const NpyLayout& layout : {NpyLayout{}, kFortran}) {
    const auto path = files.write("a.npy", npyFile(volume, layout));
    const auto alone = openSource(path);
    EXPECT_EQ(alone->info().geometry.worldOf({1, 1, 1}), glm::dvec3(1));
    EXPECT_EQ(alone->info().geometry.frame, PatientFrame::kUnknown);
    ASSERT_EQ(alone->info().notes.size(), 1u);
    EXPECT_NE(alone->info().notes[0].find("(3, 4, 5) of the array are taken as z, y, x"), std::string::npos)
        << alone->info().notes[0];
    SourceOptions options;
    options.spacing = glm::dvec3(2, 3, 4);
    const auto spaced = openSource(path, options);
    EXPECT_EQ(spaced->info().geometry.worldOf({1, 1, 1}), glm::dvec3(2, 3, 4));
    EXPECT_TRUE(spaced->info().notes.empty());
    EXPECT_EQ(spaced->info().files, std::vector{path});
  }
}

TEST(IngestNpy, LastAxisOfThree_isNotedAsPossibleColours) {
  const ForeignFiles files;
  SourceOptions options;
  options.spacing = glm::dvec3(1);
  const auto notesOf = [&](const Extent3& dims) {
    return openSource(files.write("a.npy", npyFile(randomVolume(dims, VoxelType::u8, 245))), options)->info().notes;
  };
  ASSERT_EQ(notesOf({3, 16, 16}).size(), 1u);
  EXPECT_NE(notesOf({3, 16, 16})[0].find("colours"), std::string::npos);
  EXPECT_TRUE(notesOf({5, 16, 16}).empty());
  EXPECT_TRUE(notesOf({3, 4, 16}).empty());
}

// Known: an axis of length 1 does not change the order of the voxels.
TEST(IngestNpy, FurtherAxesOfLength1_areDropped) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::i16, 251);
  for (const bool fortran_order : {false, true}) {
    std::string whole = npyFile(volume, {.fortran_order = fortran_order});
    const std::string voxels = whole.substr(whole.size() - volume.voxels.size());
    for (const char* shape : {"1, 3, 4, 5", "3, 1, 4, 5", "3, 4, 5, 1", "1, 1, 3, 4, 5", "1, 3, 4, 1, 5, 1"}) {
      SCOPED_TRACE(shape);
      const std::string header = npyHeader(std::string("{'descr': '<i2', 'fortran_order': ") +
                                           (fortran_order ? "True" : "False") + ", 'shape': (" + shape + "), }");
      expectReadsBack(volume, files.write("a.npy", header + voxels), 252);
    }
  }
  // Of several axes of length 1 the first is the further one: an image of 4 rows is a volume of one slice.
  const ForeignVolume slice = randomVolume({5, 4, 1}, VoxelType::u8, 253);
  const std::string header = npyHeader("{'descr': '|u1', 'fortran_order': False, 'shape': (1, 1, 4, 5), }");
  expectReadsBack(slice, files.write("a.npy", header + slice.stored(false)), 254);
}

TEST(IngestNpy, WhatIsNotReadIsRefusedByName) {
  // Known: each header is one that NumPy writes, and the message must name what is in the way.
  const ForeignFiles files;
  const auto refused = [&](const std::string& descr, const std::string& shape, const std::string& part) {
    const std::string header =
        npyHeader("{'descr': " + descr + ", 'fortran_order': False, 'shape': (" + shape + "), }");
    expectRefused(files.write("a.npy", header + std::string(64, 'x')), ErrorCode::kUnsupported, part);
  };
  const std::string cube = "2, 2, 2";
  refused("'<f16'", cube, "save the array as float64");
  refused("'|b1'", cube, "truth values, which Kiln does not read; save the array as uint8");
  refused("'<c8'", cube, "complex numbers");
  refused("'|O'", cube, "Python objects");
  refused("'|V12'", cube, "records");
  refused("'<U5'", cube, "not numbers");
  refused("'<M8[ns]'", cube, "not numbers");
  refused("''", cube, "not numbers");
  refused("'<u2\\n'", cube, "not numbers");
  refused("[('a', '<u2'), ('b', '<f4')]", cube, "records of several fields");
  refused("('<f4', (3,))", cube, "records of several fields");
  refused("'|u1'", "2, 2, 2, 2", "shape: '(2, 2, 2, 2)' has 4 axes");
  refused("'|u1'", "8, 8", "'(8, 8)' has 2 axes");
  refused("'|u1'", "64,", "'(64)' has 1 axis;");
  refused("'|u1'", "", "0 axes");
  for (const auto& [version, part] : {std::pair{"\x04\0", "version 4.0"}, {"\x01\x01", "version 1.1"}, {"\0\0", "0.0"}})
    expectRefused(files.write("a.npy", "\x93NUMPY" + std::string(version, 2) + std::string(64, ' ')),
                  ErrorCode::kUnsupported, part);
}

TEST(IngestNpy, HostileHeadersAreFormatErrors) {
  // Known: none of the texts is a dictionary of the three keys, or its numbers contradict the length of the file.
  const ForeignFiles files;
  const std::string type = "'descr': '|u1'", order = "'fortran_order': False";
  const auto refused = [&](const std::string& dictionary, const std::string& part) {
    expectRefused(files.write("a.npy", npyHeader(dictionary) + std::string(64, 'x')), ErrorCode::kFormat, part);
  };
  const auto shaped = [&](const std::string& shape) { return "{" + type + ", " + order + ", 'shape': " + shape + "}"; };
  refused("", "byte 64: '{' is expected (the header ends here)");
  refused("[1, 2]", "byte 10: '{' is expected (found '[1, 2]");
  refused("{}", "'descr' is missing");
  refused("{" + type + ", 'shape': (2, 2, 2)}", "'fortran_order' is missing");
  refused("{" + type + ", " + order + "}", "'shape' is missing");
  refused("{" + type + ", " + type + ", " + order + ", 'shape': (2, 2, 2)}", "'descr' is given twice");
  refused("{'more': 1, " + type + "}", "'more' is not a key");
  refused("{'\x1b[31m\n': 1}", "is not a key");
  refused("{" + type + " " + order + "}", "byte 26: '}' is expected");
  refused("{'descr' '|u1'}", "':' is expected");
  refused("{'descr': u1}", "quotation marks");
  refused("{'descr': '|u1", "has no end");
  refused("{" + type + ", 'fortran_order': 0}", "True or False");
  refused("{" + type + ", 'fortran_order': __import__('os')}", "True or False");
  refused(shaped("(2, 2, 2)") + ", 3", "only spaces");
  refused(shaped("8"), "'(' is expected");
  refused(shaped("[2, 2, 2]"), "'(' is expected");
  refused(shaped("(2, 2, 2"), "')' is expected");
  refused(shaped("(2 2, 2)"), "')' is expected");
  refused(shaped("(,)"), "a whole number");
  refused(shaped("(-2, 2, -2)"), "a whole number");
  refused(shaped("(2.0, 2, 2)"), "')' is expected");
  refused(shaped("(0x2, 2, 2)"), "')' is expected");
  refused(shaped("(9223372036854775808, 1, 1)"), "a whole number");
  refused(shaped("(" + std::string(200, '(')), "a whole number");
  std::string many;
  for (int i = 0; i < 65; ++i) many += "1, ";
  refused(shaped("(" + many + ")"), "at most 64 axes");
  refused(shaped("(0, 2, 2)"), "0 voxels");
  refused(shaped("(9223372036854775807, 1, 1)"), "9223372036854775807 voxels");
  refused(shaped("(2147483647, 2147483647, 2147483647)"), "2^63");
  refused(shaped("(4, 4, 5)"), "the header's dimensions need 80");
  refused("{'descr': '|u2', " + order + ", 'shape': (2, 2, 2)}", "'|u2' has no byte order");
  refused("{'descr': 'f4', " + order + ", 'shape': (2, 2, 2)}", "'f4' has no byte order");
}

TEST(IngestNpy, WrongLengthsAreFormatErrors) {
  // Known: the length of the header is a number at byte 8, and the voxels fill the rest.
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 261);
  for (const NpyLayout& layout : {NpyLayout{}, kFortran}) {
    const std::string whole = npyFile(volume, layout);
    for (const int length : {0, 1, 30, 119, 178, 179, 65535}) {
      std::string wrong = whole;
      wrong[8] = static_cast<char>(length & 0xff), wrong[9] = static_cast<char>(length >> 8);
      expectRefused(files.write("a.npy", wrong), ErrorCode::kFormat, "byte");
    }
    const auto source = openSource(files.write("a.npy", whole + "xyz"));
    EXPECT_TRUE(readWhole(*source) == volume.voxels);
    EXPECT_EQ(source->info().notes.back(), "a.npy: 3 bytes behind the header's dimensions not read");
  }
  // A length of 4 GiB is refused before memory is taken for it.
  std::string second = npyFile(volume, {.major_version = 2});
  second.replace(8, 4, "\xff\xff\xff\xff");
  expectRefused(files.write("a.npy", second), ErrorCode::kFormat, "byte 8: the header has 4294967295 bytes");
}

TEST(IngestNpy, EveryCutIsNoticedAndFlipsAreHarmless) {
  // Known: the voxels end with the file, so no cut holds all of them.
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::f32, 271);
  const auto path = files.directory() / "a.npy";
  for (const int version : {1, 2, 3}) {
    for (const bool fortran_order : {false, true}) {
      const std::string whole = npyFile(volume, {version, true, fortran_order});
      expectNoCutGoesUnnoticed(volume, files, "a.npy", whole, path);
      expectBitFlipsAreHarmless(files, "a.npy", whole, whole.size() - volume.voxels.size(), path, 272);
    }
  }
}

// A file that is cut after it was opened, as by a writer that begins anew.
TEST(IngestNpy, CutWhileReading_isAnError) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 281);
  const auto path = files.write("a.npy", npyFile(volume, kFortran));
  const auto source = openSource(path);
  std::filesystem::resize_file(path, 150);
  expectError([&] { readWhole(*source); }, ErrorCode::kIo, "byte 150: the file ends here");
}

TEST(IngestNpy, ContentThenNameDecides) {
  // Known: the contract of openSource.
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 291);
  const std::string whole = npyFile(volume);
  EXPECT_EQ(openSource(files.write("a.dat", whole))->info().format, "NumPy");
  expectRefused(files.write("b.npy", "NUMPY" + whole.substr(6)), ErrorCode::kFormat, "not a NumPy array");
  expectRefused(files.write("c.npy.gz", gzipped(whole)), ErrorCode::kUnsupported, "gzip-compressed NumPy");
  SourceOptions options;
  options.dims = volume.dims, options.type = volume.type;
  expectRefused(files.write("d.npy", whole), ErrorCode::kUsage, "--dims", options);
}

}  // namespace
}  // namespace kiln::test
