// Legacy files of VTK. Known because the test writes the header as text and the voxels big-endian or as numbers.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "ingest/open_source.h"
#include "support/files/foreign_files.h"

namespace kiln::test {
namespace {

constexpr const char* kLegacyTypes[] = {"unsigned_char", "char", "unsigned_short", "short",
                                        "unsigned_int",  "int",  "float",          "double"};

std::string legacyStart(const Extent3& dims, bool binary, const std::string& kind = "POINT_DATA") {
  const int cell = kind == "CELL_DATA" ? 1 : 0;
  return fmt::format(
      "# vtk DataFile Version 3.0\na title\n{}\nDATASET STRUCTURED_POINTS\nDIMENSIONS {} {} {}\nSPACING 1 1.25 2\n"
      "ORIGIN 10 20 30\n{} {}\n",
      binary ? "BINARY" : "ASCII", dims.x + cell, dims.y + cell, dims.z + cell, kind, dims.count());
}

std::string legacyData(const ForeignVolume& volume, bool binary) {
  return (binary ? volume.stored(true) : decimalsOf(volume, " \n")) + "\n";
}

std::string legacyScalars(const ForeignVolume& volume, bool binary, const std::string& name = "v") {
  return fmt::format("SCALARS {} {}\nLOOKUP_TABLE default\n", name, kLegacyTypes[static_cast<int>(volume.type)]) +
         legacyData(volume, binary);
}

TEST(IngestLegacyVtk, EveryTypeReadsBackFromBytesAndText) {
  const ForeignFiles files;
  for (const VoxelType type : kAllTypes) {
    for (const bool binary : {false, true}) {
      SCOPED_TRACE(testing::Message() << nameOf(type) << " binary " << binary);
      const ForeignVolume volume = randomVolume({13, 9, 7}, type, 501);
      const auto path = files.write("a.vtk", legacyStart(volume.dims, binary) + legacyScalars(volume, binary));
      expectReadsBack(volume, path, 502);
      EXPECT_EQ(openSource(path)->order(), binary ? ReadOrder::kAnyBox : ReadOrder::kForward);
    }
  }
}

// VTK writes unsigned characters as colours: as text in shares of 255 with six digits.
TEST(IngestLegacyVtk, ColoursAsTextAreSharesOf255) {
  const ForeignFiles files;
  ForeignVolume volume{{16, 4, 4}, VoxelType::u8, {}};
  std::string text = legacyStart(volume.dims, false) + "COLOR_SCALARS v 1\n";
  for (int value = 0; value < 256; ++value) {
    volume.voxels.push_back(static_cast<std::byte>(value));
    text += fmt::format("{:.6g} ", value / 255.0);
  }
  EXPECT_TRUE(readWhole(*openSource(files.write("a.vtk", text + "\n"))) == volume.voxels);
  for (const char* const wrong : {"1.5", "-0.1", "nan", "x"})
    expectRefused(files.write("b.vtk", replaced(text, "0.996078 1 ", fmt::format("0.996078 {} ", wrong))),
                  ErrorCode::kFormat, "is not a share from 0 to 1");
}

TEST(IngestLegacyVtk, PointsAndCellsHaveTheirPlaces) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 511);
  const auto points = openSource(files.write("a.vtk", legacyStart(volume.dims, true) + legacyScalars(volume, true)));
  EXPECT_EQ(points->info().geometry.worldOf({0, 0, 0}), glm::dvec3(10, 20, 30));
  EXPECT_EQ(points->info().geometry.worldOf({1, 1, 1}), glm::dvec3(11, 21.25, 32));
  const auto cells =
      openSource(files.write("b.vtk", legacyStart(volume.dims, true, "CELL_DATA") + legacyScalars(volume, true)));
  EXPECT_EQ(cells->info().geometry.worldOf({0, 0, 0}), glm::dvec3(10.5, 20.625, 31));
  EXPECT_TRUE(readWhole(*cells) == volume.voxels);
}

// Known: other arrays stand in front of and behind the voxels, with metadata as VTK 5 writes them.
TEST(IngestLegacyVtk, ArrayAmongOthersIsFound) {
  const ForeignFiles files;
  const ForeignVolume first = randomVolume(kFewVoxels, VoxelType::u16, 521);
  const ForeignVolume second = randomVolume(kFewVoxels, VoxelType::f32, 522);
  const std::string vectors(60 * 3 * 4, '\n');
  const std::string whole =
      legacyStart(first.dims, true) + "VECTORS flow float\n" + vectors + "\n" +
      "METADATA\nINFORMATION 0\n\nFIELD FieldData 2\nn 1 1 vtktypeint64\n12345678\nw 1 60 float\n" +
      second.stored(true) + "\n" + legacyScalars(first, true);
  const auto path = files.write("a.vtk", whole);
  expectReadsBack(first, path, 523);
  EXPECT_EQ(openSource(path)->info().notes,
            std::vector<std::string>{"array 'v' is read, and not 'w'; --channel chooses"});
  SourceOptions options;
  options.channel = "w";
  expectReadsBack(
      second, [&] { return openSource(path, options); }, 524);
  options.channel = "x";
  expectRefused(path, ErrorCode::kUsage, "'x' is none of the channels 0 to 1: 0 ('w'), 1 ('v')", options);
}

// Known: VTK writes the names "b b" and "50% x" so.
TEST(IngestLegacyVtk, NamesOfArraysAreDecoded) {
  const ForeignFiles files;
  const ForeignVolume first = randomVolume(kFewVoxels, VoxelType::u16, 527);
  const ForeignVolume second = randomVolume(kFewVoxels, VoxelType::i16, 528);
  const auto path = files.write("a.vtk", legacyStart(first.dims, true) + legacyScalars(first, true, "b%20b") +
                                             legacyScalars(second, true, "50%25%20x%2"));
  SourceOptions options;
  options.channel = "b b";
  EXPECT_TRUE(readWhole(*openSource(path, options)) == first.voxels);
  options.channel = "50% x%2";
  EXPECT_TRUE(readWhole(*openSource(path, options)) == second.voxels);
}

// Known: VTK writes facts about the whole image in front of its dimensions.
TEST(IngestLegacyVtk, FieldOfTheWholeImage_IsPassedOver) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::i16, 525);
  for (const bool binary : {false, true}) {
    std::string whole = legacyStart(volume.dims, binary) + legacyScalars(volume, binary);
    const std::string field =
        binary ? "FIELD FieldData 1\nTIME 1 1 double\n12345678\n"
               : "FIELD FieldData 3\nTIME 1 1 double\n0.5\nMETADATA\nINFORMATION 0\n\nnames 1 2 string\na b\n\n"
                 "M 3 3 int\n1 2 3 4\n5 6 7 8 9\n";
    whole.insert(whole.find("DIMENSIONS"), field);
    expectReadsBack(volume, files.write("a.vtk", whole), 526);
  }
}

// Known: the bytes are those of VTK 9.1's writer. A string begins with its length, and eight bits share a byte.
TEST(IngestLegacyVtk, StringsBitsAndEmptyArraysArePassedOver) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::i16, 529);
  const std::string long_text(300, '\n');
  const std::vector<std::string> of_binary = {
      "FIELD FieldData 0\n", "FIELD FieldData 1\nnone 1 0 float\n\n", "FIELD FieldData 1\nflags 1 9 bit\n\xff\x80\n",
      "FIELD FieldData 2\nnames 1 2 string\n\xc5hello\x81\x2c" + long_text + "\nTIME 1 1 double\n12345678\n"};
  const std::vector<std::string> of_text = {"FIELD FieldData 0\n", "FIELD FieldData 1\nnone 1 0 float\n\n",
                                            "FIELD FieldData 1\nflags 1 9 bit\n1 1 1 1 1 1 1 1 1 \n"};
  for (const bool binary : {false, true}) {
    for (const std::string& field : binary ? of_binary : of_text) {
      SCOPED_TRACE(testing::Message() << field.substr(0, 40) << " binary " << binary);
      std::string whole = legacyStart(volume.dims, binary) + legacyScalars(volume, binary);
      whole.insert(whole.find("DIMENSIONS"), field);
      expectReadsBack(volume, files.write("a.vtk", whole), 530);
    }
  }
  std::string cut = legacyStart(volume.dims, true) + legacyScalars(volume, true);
  cut.insert(cut.find("DIMENSIONS"),
             std::string("FIELD FieldData 1\nnames 1 1 string\n\x3f\xff\xff\xff\xff\xff\xff\xff", 43));
  expectRefused(files.write("a.vtk", cut), ErrorCode::kUnsupported, "holds no array of one number");
}

// VTK writes vtkIdType as 32 bits.
TEST(IngestLegacyVtk, OtherNamesOfTypes_AreRead) {
  const ForeignFiles files;
  for (const auto& [name, type] : {std::pair{"signed_char", VoxelType::i8}, {"vtkIdType", VoxelType::i32}}) {
    for (const bool binary : {false, true}) {
      SCOPED_TRACE(testing::Message() << name << " binary " << binary);
      const ForeignVolume volume = randomVolume(kFewVoxels, type, 533);
      expectReadsBack(volume,
                      files.write("a.vtk", legacyStart(volume.dims, binary) +
                                               fmt::format("SCALARS v {}\nLOOKUP_TABLE default\n", name) +
                                               legacyData(volume, binary)),
                      534);
    }
  }
}

// As filters of VTK write them.
TEST(IngestLegacyVtk, NumbersOfPointsBesideAnArray_AreNoImage) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::f32, 535);
  const ForeignVolume ids = randomVolume(kFewVoxels, VoxelType::i32, 536);
  const std::string ids_text = "vtkOriginalPointIds 1 60 vtkIdType\n" + legacyData(ids, true) + "\n";
  const std::string start = legacyStart(volume.dims, true) + "FIELD FieldData ";
  expectReadsBack(volume, files.write("a.vtk", start + "2\n" + ids_text + "v 1 60 float\n" + legacyData(volume, true)),
                  537);
  expectReadsBack(ids, files.write("b.vtk", start + "1\n" + ids_text), 538);
}

TEST(IngestLegacyVtk, TooManyStringsAreRefused) {
  const ForeignFiles files;
  const std::string names = "FIELD FieldData 1\nnames 1 20000000 string\n" + std::string(20'000'000, '\xc0');
  expectRefused(files.write("a.vtk", legacyStart(kFewVoxels, true) + names), ErrorCode::kFormat,
                "'names' holds more than 16777216 strings");
}

TEST(IngestLegacyVtk, OtherDataAreRefused) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 531);
  const std::string whole = legacyStart(volume.dims, false) + legacyScalars(volume, false);
  const auto refused = [&](const std::string& from, const std::string& to, ErrorCode code, const std::string& part) {
    expectRefused(files.write("a.vtk", replaced(whole, from, to)), code, part);
  };
  refused("STRUCTURED_POINTS", "POLYDATA", ErrorCode::kUnsupported, "holds 'POLYDATA', not STRUCTURED_POINTS");
  refused("ASCII", "XML", ErrorCode::kFormat, "neither ASCII nor BINARY");
  refused("unsigned_char", "long", ErrorCode::kUnsupported, "found 'v' of 1 x 'long'");
  refused("unsigned_char", "unsigned_char 3", ErrorCode::kUnsupported, "found 'v' of 3");
  refused("LOOKUP_TABLE", "TABLE", ErrorCode::kFormat, "'LOOKUP_TABLE' is expected");
  refused("POINT_DATA 60", "POINT_DATA 61", ErrorCode::kFormat, "says 61 values, but the dimensions have 60");
  refused("DIMENSIONS 5 4 3", "DIMENSIONS 5 4", ErrorCode::kFormat, "'DIMENSIONS' needs a whole number");
  refused("DIMENSIONS 5", "DIMENSIONS 0", ErrorCode::kFormat, "from 1 on (found '0')");
  refused("DIMENSIONS 5 4 3\n", "", ErrorCode::kFormat, "'DIMENSIONS' is missing");
  refused("SPACING", "PLACING", ErrorCode::kFormat, "'PLACING' is not expected");
  refused("SPACING 1", "SPACING x", ErrorCode::kFormat, "needs three numbers");
  refused("default\n", "default\n256 ", ErrorCode::kFormat, "'256' is not a value of type u8");
}

void expectCutRefused(const std::filesystem::path& path) {
  EXPECT_THROW(readWhole(*openSource(path)), Error) << std::filesystem::file_size(path);
}

TEST(IngestLegacyVtk, EveryCutIsNoticedAndFlipsAreHarmless) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::i16, 541);
  std::string whole = legacyStart(volume.dims, true) + legacyScalars(volume, true);
  expectNoCutGoesUnnoticed(volume, files, "a.vtk", whole, files.directory() / "a.vtk");
  expectBitFlipsAreHarmless(files, "a.vtk", whole, whole.size() - volume.voxels.size(), files.directory() / "a.vtk",
                            542);
  // A number that is cut short is a number, so the last digit is not cut.
  whole = legacyStart(volume.dims, false) + legacyScalars(volume, false);
  whole = whole.substr(0, whole.find_last_not_of(" \n") + 2);
  for (std::size_t length = 0; length + 8 < whole.size(); ++length)
    expectCutRefused(files.write("a.vtk", whole.substr(0, length)));
}

}  // namespace
}  // namespace kiln::test
