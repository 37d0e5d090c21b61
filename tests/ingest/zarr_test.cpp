// Zarr, OME-Zarr and N5. Known because the test writes each header as text, and each chunk voxel by voxel, without the
// readers' code.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <glm/gtc/epsilon.hpp>
#include <random>

#include "ingest/open_source.h"
#include "support/files/packed_bytes.h"
#include "support/files/zarr_files.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

constexpr ZarrVersion kVersions[] = {ZarrVersion::kTwo, ZarrVersion::kThree, ZarrVersion::kN5};

class IngestZarr : public ::testing::Test {
 protected:
  fs::path in(const std::string& name) const { return files_.directory() / name; }
  void put(const std::string& name, std::string_view bytes) const { writeBelow(in(name), bytes); }
  SourceInfo info(const std::string& name, const SourceOptions& options = {}) const {
    return openSource(in(name), options)->info();
  }
  void expectError(const std::string& name, ErrorCode code, const std::string& part,
                   const SourceOptions& options = {}) const {
    expectRefused(in(name), code, part, options);
  }
  // Writes a version 2 group of an image: its attributes, and its arrays with equal voxels.
  void putImage(const std::string& name, const ForeignVolume& volume, const std::string& multiscale,
                const std::string& more = "", const ZarrLayout& layout = {}, int scales = 1) const {
    put(name + "/.zgroup", R"({"zarr_format": 2})");
    put(name + "/.zattrs", fmt::format(R"({{"multiscales": [{}]{}}})", multiscale, more));
    for (int i = 0; i < scales; ++i) writeZarr(in(fmt::format("{}/{}", name, i)), volume, layout);
  }

  const ForeignFiles files_;
  const ForeignVolume few_ = randomVolume(kFewVoxels, VoxelType::u16, 31);
};

std::string axesOf(const std::string& names, const std::string& unit = "") {
  std::string out;
  for (const char name : names) {
    const bool space = name != 'c' && name != 't';
    out += fmt::format(R"({}{{"name": "{}", "type": "{}"{}}})", out.empty() ? "" : ", ", name,
                       space         ? "space"
                       : name == 'c' ? "channel"
                                     : "time",
                       space && !unit.empty() ? ", \"unit\": \"" + unit + "\"" : "");
  }
  return "[" + out + "]";
}

std::string imageOf(const std::string& axes, const std::string& transformations, int scales = 1) {
  std::string datasets;
  for (int i = 0; i < scales; ++i)
    datasets +=
        fmt::format(R"({}{{"path": "{}", "coordinateTransformations": [{}]}})", i == 0 ? "" : ", ", i, transformations);
  return fmt::format(R"({{"version": "0.4", "axes": {}, "datasets": [{}]}})", axes, datasets);
}

const std::string kScale = R"({"type": "scale", "scale": [4, 3, 2]})";

SourceOptions withChannel(const std::string& channel) {
  SourceOptions out;
  out.channel = channel;
  return out;
}
SourceOptions withTime(std::int64_t time) {
  SourceOptions out;
  out.time = time;
  return out;
}
SourceOptions withScale(std::int64_t scale) {
  SourceOptions out;
  out.scale = scale;
  return out;
}

TEST_F(IngestZarr, EveryTypeCodecVersionAndByteOrder_ReadsBack) {
  int n = 0;
  const auto expectBack = [&](VoxelType type, const ZarrLayout& layout) {
    const ForeignVolume volume = randomVolume(kFewVoxels, type, 100 + static_cast<std::uint64_t>(n));
    const fs::path folder = writeZarr(in(fmt::format("{}.zarr", n++)), volume, layout);
    SCOPED_TRACE(folder);
    const std::unique_ptr<VolumeSource> source = openSource(folder);
    EXPECT_EQ(source->info().type, type);
    EXPECT_TRUE(readWhole(*source) == volume.voxels);
  };
  for (const ZarrVersion version : kVersions) {
    for (const bool big_endian : {false, true}) {
      for (const VoxelType type : kAllTypes) expectBack(type, {.version = version, .big_endian = big_endian});
      for (const ZarrCodec codec : kZarrCodecs)
        expectBack(VoxelType::i32, {.version = version, .codec = codec, .big_endian = big_endian});
    }
    expectReadsBack(few_, writeZarr(in(fmt::format("boxes{}.zarr", n)), few_, {.version = version}), 302);
  }
}

TEST_F(IngestZarr, EveryOrderAndSubsetOfAxesChunkShapeAndSeparator_ReadsBack) {
  const ForeignVolume volume = randomVolume({7, 6, 5}, VoxelType::i16, 32);
  std::string names = "xyz";
  int n = 0;
  do {
    for (const std::int64_t chunk : {1, 2, 4, 9}) {
      ZarrLayout layout{.version = ZarrVersion::kThree, .names_axes = true};
      layout.axes.clear();
      for (const char name : names) layout.axes.push_back({name, chunk + (name == 'y' ? 1 : 0)});
      layout.stored_axes = n % 2 == 0 ? std::vector<int>{} : std::vector<int>{1, 2, 0};
      layout.separator = n % 3 == 0 ? '.' : '/';
      expectReadsBack(volume, writeZarr(in(fmt::format("{}.zarr", n++)), volume, layout), 303);
    }
  } while (std::next_permutation(names.begin(), names.end()));
  for (const char separator : {'\0', '.', '/'}) {
    for (const std::vector<int>& order : {std::vector<int>{}, std::vector<int>{2, 1, 0}})
      expectReadsBack(
          volume, writeZarr(in(fmt::format("{}.zarr", n++)), volume, {.stored_axes = order, .separator = separator}),
          304);
  }
  // An array of two axes is one slice.
  const ForeignVolume slice = randomVolume({7, 6, 1}, VoxelType::u8, 33);
  for (const ZarrVersion version : kVersions)
    expectReadsBack(
        slice, writeZarr(in(fmt::format("{}.zarr", n++)), slice, {.version = version, .axes = {{'y', 4}, {'x', 4}}}),
        305);
}

// Version 2 may leave the separator open, though its chunks lie in folders: chunks must not count as missing.
TEST_F(IngestZarr, SeparatorThatTheHeaderLeavesOpen_IsThatOfTheChunks) {
  writeZarr(in("a.zarr"), few_, {.separator = '/'});
  put("a.zarr/.zarray", zarrHeader(few_, {}));
  expectReadsBack(few_, in("a.zarr"), 306);
}

TEST_F(IngestZarr, ShardsWithTheIndexAtEitherEnd_ReadBack) {
  const ForeignVolume volume = randomVolume({11, 9, 8}, VoxelType::u16, 34);
  int n = 0;
  for (const bool at_start : {false, true}) {
    for (const ZarrCodec codec : {ZarrCodec::kRaw, ZarrCodec::kZstd, ZarrCodec::kBlosc}) {
      for (const bool checksum : {false, true}) {
        ZarrLayout layout{.version = ZarrVersion::kThree, .codec = codec};
        layout.chunks_in_shard = 2, layout.index_at_start = at_start, layout.checksum = checksum;
        if (n % 2 == 1) layout.stored_axes = {2, 0, 1};
        expectReadsBack(volume, writeZarr(in(fmt::format("{}.zarr", n++)), volume, layout), 307);
      }
    }
  }
}

// Known: every second chunk of the volume has the fill value alone, and no file. The names of numbers are those of the
// three specifications and of NetCDF and GDAL.
TEST_F(IngestZarr, MissingChunksHaveTheFillValueInEachSpelling) {
  struct Case {
    VoxelType type;
    const char* fill;
    double value;
  };
  const Case cases[] = {{VoxelType::u8, "7", 7},
                        {VoxelType::u8, "7.0", 7},
                        {VoxelType::u8, "true", 1},
                        {VoxelType::u8, "\"\"", 0},
                        {VoxelType::i16, "-32768", -32768},
                        {VoxelType::u16, "\"65535\"", 65535},
                        {VoxelType::u16, "[9]", 9},
                        {VoxelType::f32, "0.5", 0.5},
                        {VoxelType::f32, "\"Infinity\"", INFINITY},
                        {VoxelType::f32, "\"+Infinity\"", INFINITY},
                        {VoxelType::f32, "\"-Infinity\"", -INFINITY},
                        {VoxelType::f64, "-Infinity", -INFINITY},
                        {VoxelType::f64, "1e-3", 1e-3},
                        {VoxelType::f32, "\"NaN\"", NAN},
                        {VoxelType::f32, "NaN", NAN}};
  int n = 0;
  for (const ZarrVersion version : {ZarrVersion::kTwo, ZarrVersion::kThree}) {
    for (const Case& of : cases) {
      SCOPED_TRACE(of.fill);
      const fs::path folder = in(fmt::format("{}.zarr", n++));
      const ForeignVolume empty = {kFewVoxels, of.type, std::vector<std::byte>(60 * sizeOf(of.type))};
      ZarrLayout layout{.version = version};
      layout.fill = of.fill;
      writeBelow(folder / zarrHeaderName(version), zarrHeader(empty, layout));
      const std::unique_ptr<VolumeSource> source = openSource(folder);
      const std::vector<std::byte> got = readWhole(*source);
      withVoxelType(of.type, [&]<class T>(std::type_identity<T>) {
        for (std::size_t i = 0; i < 60; ++i) {
          T voxel;
          std::memcpy(&voxel, got.data() + i * sizeof(T), sizeof(T));
          EXPECT_TRUE(static_cast<double>(voxel) == of.value || (std::isnan(of.value) && voxel != voxel)) << +voxel;
        }
      });
      ASSERT_FALSE(source->info().notes.empty());
      EXPECT_NE(source->info().notes.back().find("no chunk of the array exists"), std::string::npos);
    }
  }
  // Bits of floats, the highest first.
  put("bits.zarr/zarr.json",
      zarrHeader({kFewVoxels, VoxelType::f32, {}}, {.version = ZarrVersion::kThree, .fill = "\"0x3fc00000\""}));
  const std::vector<std::byte> got = readWhole(*openSource(in("bits.zarr")));
  float voxel;
  std::memcpy(&voxel, got.data() + 59 * sizeof voxel, sizeof voxel);
  EXPECT_EQ(voxel, 1.5f);
}

TEST_F(IngestZarr, ChunksLeftOutBesideOthers_HaveTheFillValue) {
  ForeignVolume volume = randomVolume({8, 6, 4}, VoxelType::u8, 35);
  for (std::size_t i = 0; i < 96; ++i) volume.voxels[i] = std::byte{0x11};
  int n = 0;
  for (const ZarrVersion version : {ZarrVersion::kTwo, ZarrVersion::kThree}) {
    for (const std::int64_t in_shard : {0, 2}) {
      ZarrLayout layout{.version = version, .fill = "17", .fill_byte = '\x11'};
      layout.chunks_in_shard = version == ZarrVersion::kThree ? in_shard : 0;
      expectReadsBack(volume, writeZarr(in(fmt::format("{}.zarr", n++)), volume, layout), 308);
    }
  }
}

// A fill value that no voxel has matters only where a chunk is missing: 64-bit arrays of NetCDF state -2^63.
TEST_F(IngestZarr, FillValueThatDoesNotFit_IsAnErrorOnceAChunkIsMissing) {
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::i32, 36);
  std::string wide;
  for (std::size_t i = 0; i < 60; ++i) {
    std::int32_t voxel;
    std::memcpy(&voxel, volume.voxels.data() + 4 * i, 4);
    wide += littleEndian(static_cast<std::uint64_t>(std::int64_t{voxel}), 8);
  }
  const std::string header =
      R"({"zarr_format": 2, "shape": [3, 4, 5], "chunks": [3, 4, 5], "dtype": "<i8", "compressor": null,
          "fill_value": -9223372036854775808, "order": "C", "filters": null})";
  put("a.zarr/.zarray", header);
  put("a.zarr/0.0.0", wide);
  expectReadsBack(volume, in("a.zarr"), 309);
  fs::remove(in("a.zarr/0.0.0"));
  expectError("a.zarr", ErrorCode::kFormat, "fill_value: chunks are missing, and their fill value -9.22");
  wide[7] = '\x40';
  put("a.zarr/0.0.0", wide);
  expectError("a.zarr", ErrorCode::kFormat, "0.0.0: the value 4");
}

TEST_F(IngestZarr, HalfFloatsAndTruthValuesAreRead) {
  const auto header = [](const char* dtype) {
    return fmt::format(R"({{"zarr_format": 2, "shape": [1, 1, 4], "chunks": [1, 1, 4], "dtype": "{}",
                            "compressor": null, "fill_value": 0, "order": "C", "filters": null}})",
                       dtype);
  };
  put("half.zarr/.zarray", header("<f2"));
  put("half.zarr/0.0.0", std::string("\x00\x3c\x00\xc0\x01\x00\xff\x7b", 8));
  const std::vector<std::byte> half = readWhole(*openSource(in("half.zarr")));
  float floats[4];
  std::memcpy(floats, half.data(), sizeof floats);
  EXPECT_EQ(std::vector<float>(floats, floats + 4), (std::vector<float>{1, -2, 0x1p-24f, 65504}));
  put("object.zarr/zarr.json",
      R"({"zarr_format": 3, "node_type": "array", "shape": [1, 1, 4], "data_type": {"name": "uint8"}, "fill_value": 7,
          "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [1, 1, 4]}},
          "chunk_key_encoding": {"name": "default"}, "codecs": ["bytes"]})");
  EXPECT_EQ(readWhole(*openSource(in("object.zarr"))), std::vector(4, std::byte{7}));
  put("bool.zarr/.zarray", header("|b1"));
  put("bool.zarr/0.0.0", std::string("\1\0\1\1", 4));
  const auto truths = openSource(in("bool.zarr"));
  EXPECT_EQ(truths->info().type, VoxelType::u8);
  EXPECT_EQ(readWhole(*truths), (std::vector{std::byte{1}, std::byte{0}, std::byte{1}, std::byte{1}}));
}

// Chunks of several channels and times: voxels of other channels are complements.
TEST_F(IngestZarr, ChannelsAndTimesAreChosenByNumberAndName) {
  const ForeignVolume volume = randomVolume({6, 5, 4}, VoxelType::u16, 37);
  ZarrLayout layout;
  layout.axes = {{'t', 2, 3, 2}, {'c', 2, 3, 1}, {'z', 3}, {'y', 2}, {'x', 4}};
  putImage("a.zarr", volume, imageOf(axesOf("tczyx"), R"({"type": "scale", "scale": [1, 1, 4, 3, 2]})"),
           R"(, "omero": {"channels": [{"label": "DAPI"}, {"label": "GFP"}, {"label": "2"}]})", layout);
  SourceOptions chosen = withChannel("GFP");
  chosen.time = 2;
  const auto open = [&] { return openSource(in("a.zarr"), chosen); };
  expectReadsBack(volume, open, 310);
  const std::string by_name = open()->info().format;
  EXPECT_EQ(by_name, "Zarr v2, OME-Zarr, array '0', time 2, channel 1");
  chosen.channel = "1";
  expectReadsBack(volume, open, 311);
  EXPECT_EQ(open()->info().format, by_name);
  expectError("a.zarr", ErrorCode::kUsage, "holds 3 channels; choose one with --channel, from 0 to 2: 0 ('DAPI'), 1",
              withTime(0));
  expectError("a.zarr", ErrorCode::kUsage, "holds 3 times; choose one with --time", withChannel("0"));
  SourceOptions late = withChannel("0");
  late.time = 3;
  expectError("a.zarr", ErrorCode::kUsage, "--time: expected a number from 0 to 2 (found 3)", late);
  late = withChannel("RFP");
  late.time = 0;
  expectError("a.zarr", ErrorCode::kUsage, "'RFP' is none of the channels 0 to 2", late);
  putImage("twins.zarr", volume, imageOf(axesOf("tczyx"), R"({"type": "scale", "scale": [1, 1, 4, 3, 2]})"),
           R"(, "omero": {"channels": [{"label": "GFP"}, {"label": "DAPI"}, {"label": "GFP"}]})", layout);
  late = withChannel("GFP");
  late.time = 0;
  expectError("twins.zarr", ErrorCode::kUsage, "'GFP' names several channels; choose one by its number", late);
  // Without names, the axes in front of the last three are a channel and a time.
  layout.axes = {{'c', 1, 2, 1}, {'z', 3}, {'y', 2}, {'x', 4}};
  writeZarr(in("plain.zarr"), volume, layout);
  expectReadsBack(
      volume, [&] { return openSource(in("plain.zarr"), withChannel("1")); }, 312);
  expectReadsBack(
      volume, [&] { return openSource(in("plain.zarr"), withTime(1)); }, 313);
  writeZarr(in("one.zarr"), volume);
  expectError("one.zarr", ErrorCode::kUsage, "expected a number from 0 to 0 (found 1)", withTime(1));
  expectError("one.zarr", ErrorCode::kUsage, "--scale: applies to an image of several resolutions", withScale(0));
}

TEST_F(IngestZarr, ScalesAreChosenByNumber) {
  putImage("a.zarr", few_, imageOf(axesOf("zyx"), kScale, 2), "", {}, 2);
  const ForeignVolume coarse = randomVolume({3, 2, 2}, VoxelType::u16, 38);
  fs::remove_all(in("a.zarr/1"));
  writeZarr(in("a.zarr/1"), coarse);
  expectReadsBack(few_, in("a.zarr"), 314);
  expectReadsBack(
      coarse, [&] { return openSource(in("a.zarr"), withScale(1)); }, 315);
  expectError("a.zarr", ErrorCode::kUsage, "must be a number from 0 to 1 (found 2)", withScale(2));
  EXPECT_NE(info("a.zarr", withScale(1)).format, info("a.zarr").format);
  // The array's folder has the image's place.
  for (const char* const spelling : {"a.zarr/1", "a.zarr/1/", "a.zarr/0/../1", "a.zarr/./1"}) {
    EXPECT_EQ(info(spelling).geometry.spacing(), glm::dvec3(2, 3, 4)) << spelling;
    EXPECT_EQ(info(spelling).geometry.dims, coarse.dims);
  }
}

// Known: x = 2 · 10 + 100 in the multiscale's transformation after the data set's.
TEST_F(IngestZarr, TransformationsOfDataSetAndImageApplyInOrder) {
  const std::string set = kScale + R"(, {"type": "translation", "translation": [40, 30, 20]})";
  const std::string image =
      imageOf(axesOf("zyx", "micrometer"), set).substr(0, imageOf(axesOf("zyx", "micrometer"), set).size() - 1) +
      R"(, "coordinateTransformations": [{"type": "scale", "scale": [10, 10, 10]},
          {"type": "translation", "translation": [300, 200, 100]}, {"type": "identity"}]})";
  putImage("a.zarr", few_, image);
  const VolumeGeometry geometry = info("a.zarr").geometry;
  EXPECT_EQ(geometry.unit, "um");
  EXPECT_EQ(geometry.worldOf({0, 0, 0}), glm::dvec3(300, 500, 700));
  EXPECT_EQ(geometry.worldOf({1, 1, 1}), glm::dvec3(320, 530, 740));
  EXPECT_TRUE(info("a.zarr").notes.empty());
  SourceOptions spaced;
  spaced.spacing = glm::dvec3(1, 2, 3);
  EXPECT_EQ(info("a.zarr", spaced).geometry.spacing(), glm::dvec3(1, 2, 3));
  for (const char* const refused : {"affine", "rotation", "coordinates"}) {
    putImage("b.zarr", few_, imageOf(axesOf("zyx"), fmt::format(R"({{"type": "{}", "path": "t"}})", refused)));
    expectError("b.zarr", ErrorCode::kUnsupported, fmt::format("the transformation '{}' is not read", refused));
  }
  putImage("b.zarr", few_, imageOf(axesOf("zyx"), R"({"type": "scale", "scale": [1, 1]})"));
  expectError("b.zarr", ErrorCode::kFormat, "must have a number for each of 3 axes");
  for (const char* const scale : {"0", "\"NaN\"", "\"Infinity\""}) {
    putImage("b.zarr", few_, imageOf(axesOf("zyx"), fmt::format(R"({{"type": "scale", "scale": [1, 1, {}]}})", scale)));
    expectError("b.zarr", ErrorCode::kFormat, "geometry");
  }
}

TEST_F(IngestZarr, LengthsOfOtherUnitsAreConvertedToThatOfX) {
  const auto axes = [](const char* z, const char* x) {
    return fmt::format(
        R"([{{"name": "z", "unit": "{}"}}, {{"name": "y", "unit": "{}"}}, {{"name": "x", "unit": "{}"}}])", z, x, x);
  };
  putImage("a.zarr", few_, imageOf(axes("millimeter", "micrometer"), kScale));
  EXPECT_EQ(info("a.zarr").geometry.spacing(), glm::dvec3(2, 3, 4000));
  putImage("a.zarr", few_, imageOf(axes("furlong", "micrometer"), kScale));
  EXPECT_EQ(info("a.zarr").geometry.spacing(), glm::dvec3(2, 3, 4));
  ASSERT_EQ(info("a.zarr").notes.size(), 1u);
  EXPECT_NE(info("a.zarr").notes[0].find("along z are in 'furlong' and along x in 'micrometer'"), std::string::npos);
  putImage("a.zarr", few_, imageOf(axes("MILLIMETER", "Micrometer"), kScale));
  EXPECT_EQ(info("a.zarr").geometry.spacing(), glm::dvec3(2, 3, 4000));
  EXPECT_EQ(info("a.zarr").geometry.unit, "um");
  putImage("a.zarr", few_, imageOf(axes("furlong", "furlong"), kScale));
  EXPECT_EQ(info("a.zarr").geometry.unit, "");
  EXPECT_NE(info("a.zarr").notes[0].find("the unit 'furlong' is unknown"), std::string::npos);
}

// Known: RFC-4 names the direction of growing indices; RAS axes grow to the right, to the front and up.
TEST_F(IngestZarr, AnatomicalOrientationBecomesRas) {
  const auto axes = [](const char* z, const char* y, const char* x) {
    const auto axis = [](char name, const char* direction) {
      return fmt::format(R"({{"name": "{}", "type": "space", "orientation": {{"type": "anatomical", "value": "{}"}}}})",
                         name, direction);
    };
    return fmt::format("[{}, {}, {}]", axis('z', z), axis('y', y), axis('x', x));
  };
  putImage("a.zarr", few_, imageOf(axes("superior-to-inferior", "left-to-right", "anterior-to-posterior"), kScale));
  const VolumeGeometry geometry = info("a.zarr").geometry;
  EXPECT_EQ(geometry.frame, PatientFrame::kRas);
  EXPECT_EQ(geometry.worldOf({1, 0, 0}) - geometry.worldOf({0, 0, 0}), glm::dvec3(0, -2, 0));
  EXPECT_EQ(geometry.worldOf({0, 1, 0}) - geometry.worldOf({0, 0, 0}), glm::dvec3(3, 0, 0));
  EXPECT_EQ(geometry.worldOf({0, 0, 1}) - geometry.worldOf({0, 0, 0}), glm::dvec3(0, 0, -4));
  putImage("a.zarr", few_, imageOf(axes("superior-to-inferior", "superior-to-inferior", "left-to-right"), kScale));
  EXPECT_EQ(info("a.zarr").geometry.frame, PatientFrame::kUnknown);
}

TEST_F(IngestZarr, EarlierAndLaterVersionsOfOmeAreRead) {
  // 0.1 and 0.2: five axes without names, no sizes. 0.3: names alone.
  ZarrLayout five;
  five.axes = {{'t', 1}, {'c', 1}, {'z', 2}, {'y', 3}, {'x', 4}};
  putImage("v1.zarr", few_, R"({"version": "0.1", "datasets": [{"path": "0"}]})", "", five);
  expectReadsBack(few_, in("v1.zarr"), 316);
  EXPECT_NE(info("v1.zarr").notes.at(0).find("voxels are taken as 1 x 1 x 1"), std::string::npos);
  putImage("v3.zarr", few_, R"({"version": "0.3", "axes": ["z", "y", "x"], "datasets": [{"path": "0"}]})");
  expectReadsBack(few_, in("v3.zarr"), 317);
  // 0.5: Zarr 3, below "ome".
  put("v5.zarr/zarr.json",
      fmt::format(R"({{"zarr_format": 3, "node_type": "group", "attributes": {{"ome": {{"version": "0.5",
                       "multiscales": [{}]}}}}}})",
                  imageOf(axesOf("zyx", "nanometer"), kScale)));
  writeZarr(in("v5.zarr/0"), few_, {.version = ZarrVersion::kThree});
  expectReadsBack(few_, in("v5.zarr"), 318);
  EXPECT_EQ(info("v5.zarr").geometry.unit, "nm");
  EXPECT_EQ(info("v5.zarr/0").geometry.spacing(), glm::dvec3(2, 3, 4));
}

TEST_F(IngestZarr, AxesAreNamedByTheirPlaceWhereNoneIsXOrYOrZ) {
  writeZarr(in("a.zarr"), few_);
  put("a.zarr/.zattrs", R"({"_ARRAY_DIMENSIONS": ["depth", "lat", "lon"]})");
  expectReadsBack(few_, in("a.zarr"), 319);
  EXPECT_EQ(info("a.zarr").notes.at(0), "took the axes 'lon' as x, 'lat' as y, 'depth' as z");
  put("a.zarr/.zattrs", R"({"_ARRAY_DIMENSIONS": ["X", "y", "Z"]})");
  EXPECT_EQ(info("a.zarr").geometry.dims, (Extent3{3, 4, 5}));
  put("a.zarr/.zattrs", R"({"_ARRAY_DIMENSIONS": ["x", "y", "x"]})");
  expectError("a.zarr", ErrorCode::kFormat, "two axes have the name 'x'");
  put("a.zarr/.zattrs", R"({"_ARRAY_DIMENSIONS": ["wavelength", "y", "x"]})");
  expectError("a.zarr", ErrorCode::kUnsupported, "the axis 'wavelength' of (3, 4, 5) has 3 entries");
  put("line.zarr/.zarray",
      R"({"zarr_format": 2, "shape": [9], "chunks": [9], "dtype": "|u1", "compressor": null, "fill_value": 0,
          "order": "C", "filters": null})");
  expectError("line.zarr", ErrorCode::kUnsupported, "(9) has fewer than two axes");
}

TEST_F(IngestZarr, LabelsAreLabels) {
  put("a.zarr/labels/.zgroup", R"({"zarr_format": 2})");
  putImage("a.zarr/labels/cells", few_, imageOf(axesOf("zyx"), kScale), R"(, "image-label": {"version": "0.4"})");
  putImage("a.zarr", few_, imageOf(axesOf("zyx"), kScale));
  EXPECT_EQ(info("a.zarr/labels/cells").volume_class, VolumeClass::kLabels);
  EXPECT_EQ(info("a.zarr").volume_class, VolumeClass::kUnknown);
  EXPECT_NE(info("a.zarr").notes.at(0).find("has labels in its folder 'labels'"), std::string::npos);
  EXPECT_EQ(info("a.zarr/labels").volume_class, VolumeClass::kLabels);
}

TEST_F(IngestZarr, ColoursOfLabels_areTheLook) {
  putImage("a.zarr", few_, imageOf(axesOf("zyx"), kScale), R"(, "image-label": {"colors": [
      {"label-value": 7, "rgba": [255, 128, 0, 51]}, {"label-value": 2, "rgba": [1, 2, 3, 255]},
      {"label-value": 7, "rgba": [9, 9, 9, 9]}, {"label-value": 3, "rgba": [256, 0, 0, 0]}, {"rgba": [1, 1, 1, 1]}, 5]})");
  const std::vector<DeclaredLook::Label> expected = {{2, {1, 2, 3, 255}}, {7, {255, 128, 0, 51}}};
  EXPECT_EQ(info("a.zarr").look.labels, expected);
  EXPECT_FALSE(info("a.zarr").look.ramp);
}

// Known from the keys of OMERO: a window has a start and an end inside the limits min and max.
TEST_F(IngestZarr, WindowAndColourOfTheChannel_areTheLook) {
  const auto expectRamp = [&](const std::string& channel, std::optional<DeclaredLook::Ramp> ramp) {
    putImage("a.zarr", few_, imageOf(axesOf("czyx"), R"({"type": "scale", "scale": [1, 4, 3, 2]})"),
             fmt::format(R"(, "omero": {{"channels": [{{"label": "DAPI"}}, {}]}})", channel),
             {.axes = {{'c', 1, 2}, {'z', 2}, {'y', 2}, {'x', 2}}});
    EXPECT_EQ(info("a.zarr", withChannel("1")).look, (DeclaredLook{ramp, {}})) << channel;
    EXPECT_TRUE(info("a.zarr", withChannel("DAPI")).look.empty());
  };
  const std::string window = R"("window": {"min": 0, "start": 12.5, "end": 4000, "max": 65535})";
  expectRamp(R"({"color": "00FF80", "family": "linear", "inverted": false, )" + window + "}",
             DeclaredLook::Ramp{12.5, 4000, {0, 255, 128, 255}});
  expectRamp("{" + window + "}", DeclaredLook::Ramp{12.5, 4000, {}});
  expectRamp(R"({"color": "green", )" + window + "}", DeclaredLook::Ramp{12.5, 4000, {}});
  expectRamp(R"({"color": "00FF80", "inverted": true, )" + window + "}", std::nullopt);
  expectRamp(R"({"color": "00FF80", "family": "exponential", )" + window + "}", std::nullopt);
  expectRamp(R"({"window": {"start": 5, "end": 5}})", std::nullopt);
  expectRamp(R"({"window": {"start": "a"}})", std::nullopt);
  expectRamp(R"({"window": {"start": -1.7e308, "end": 1.7e308}})", std::nullopt);
  expectRamp(R"({"window": {"start": 0, "end": 1e39}})", std::nullopt);
  expectRamp(R"({"window": {"start": -1.7e38, "end": 1.7e38}})", DeclaredLook::Ramp{-1.7e38, 1.7e38, {}});
  expectRamp(R"({"window": 3, "color": 7})", std::nullopt);
  expectRamp("3", std::nullopt);
}

TEST_F(IngestZarr, ContainersListTheirImagesAndPlatesAreRefused) {
  put("a.zarr/.zgroup", R"({"zarr_format": 2})");
  expectError("a.zarr", ErrorCode::kUnsupported, "is a Zarr or N5 group without an array");
  putImage("a.zarr/0", few_, imageOf(axesOf("zyx"), kScale));
  expectReadsBack(few_, in("a.zarr"), 320);
  EXPECT_EQ(info("a.zarr").notes.back(), "took '0' image of 1 scale, the only image");
  putImage("a.zarr/1", few_, imageOf(axesOf("zyx"), kScale, 2), "", {}, 2);
  writeZarr(in("a.zarr/mask"), few_);
  put("a.zarr/.zattrs", R"({"bioformats2raw.layout": 3})");
  expectError("a.zarr", ErrorCode::kUsage,
              "holds 3 images or arrays: '0' image of 1 scale; '1' image of 2 scales; 'mask' (3, 4, 5) uint16; name");
  expectReadsBack(few_, in("a.zarr/mask"), 321);
  put("a.zarr/.zattrs", R"({"plate": {"wells": []}})");
  expectError("a.zarr", ErrorCode::kUnsupported, "is a plate of many wells");
  put("a.zarr/.zattrs", R"({"plate": {"wells": [{"path": "B/03"}]}})");
  put("a.zarr/B/03/.zgroup", R"({"zarr_format": 2})");
  put("a.zarr/B/03/.zattrs", R"({"well": {"images": [{"path": "7"}]}})");
  expectError("a.zarr", ErrorCode::kUnsupported, "name the folder of one image, as " + in("a.zarr/B/03/7").string());
}

// xarray stores coordinates, numbers or texts, as arrays of one axis beside the volume.
TEST_F(IngestZarr, CoordinatesBesideAVolume_AreNoVolumes) {
  put("a.zarr/.zgroup", R"({"zarr_format": 2})");
  for (const char* const dtype : {"<f8", "|S3"})
    put(fmt::format("a.zarr/{}/.zarray", dtype),
        fmt::format(R"({{"zarr_format": 2, "shape": [5], "chunks": [5], "dtype": "{}", "compressor": null,
                         "fill_value": null, "order": "C", "filters": null}})",
                    dtype));
  expectError("a.zarr", ErrorCode::kUnsupported, "without an array of two axes or more");
  writeZarr(in("a.zarr/density"), few_);
  put("a.zarr/density/.zattrs", R"({"_ARRAY_DIMENSIONS": ["z", "y", "x"], "scale_factor": 0.5, "add_offset": 20})");
  expectReadsBack(few_, in("a.zarr"), 333);
  const std::vector<std::string> notes = info("a.zarr").notes;
  const std::string note =
      "the attributes say that values are 20 + 0.5 times the stored numbers; the numbers are taken as stored";
  EXPECT_NE(std::find(notes.begin(), notes.end(), note), notes.end());
}

TEST_F(IngestZarr, PathsThatLeaveTheContainerAreRefused) {
  writeZarr(in("secret"), few_);
  for (const char* const path : {"../secret", "0/../../secret", "/", "..", "", "."}) {
    putImage("a.zarr", few_, fmt::format(R"({{"axes": {}, "datasets": [{{"path": "{}"}}]}})", axesOf("zyx"), path));
    SCOPED_TRACE(path);
    EXPECT_THROW(openSource(in("a.zarr")), Error);
  }
  putImage("a.zarr", few_, fmt::format(R"({{"axes": {}, "datasets": [{{"path": "x/../0/"}}]}})", axesOf("zyx")));
  expectReadsBack(few_, in("a.zarr"), 322);
  expectReadsBack(few_, in("a.zarr/0"), 322);
}

TEST_F(IngestZarr, LinksAreFollowedAndPipesAreRefused) {
  writeZarr(in("a.zarr"), few_);
  fs::create_directory_symlink(in("a.zarr"), in("link.zarr"));
  expectReadsBack(few_, in("link.zarr"), 323);
  fs::rename(in("a.zarr/1.0.0"), in("elsewhere"));
  fs::create_symlink(in("elsewhere"), in("a.zarr/1.0.0"));
  expectReadsBack(few_, in("a.zarr"), 324);
  fs::remove(in("a.zarr/1.0.0"));
  ASSERT_EQ(::mkfifo(in("a.zarr/1.0.0").c_str(), 0600), 0);
  expectError("a.zarr", ErrorCode::kUnsupported, "1.0.0: is a pipe or a device");
  fs::remove(in("a.zarr/1.0.0"));
  fs::create_directory(in("a.zarr/1.0.0"));
  EXPECT_THROW(readWhole(*openSource(in("a.zarr"))), Error);
  fs::remove(in("a.zarr/1.0.0"));
  fs::create_symlink("1.0.0", in("a.zarr/1.0.0"));
  EXPECT_THROW(readWhole(*openSource(in("a.zarr"))), Error);
  fs::remove(in("a.zarr/.zarray"));
  ASSERT_EQ(::mkfifo(in("a.zarr/.zarray").c_str(), 0600), 0);
  EXPECT_THROW(openSource(in("a.zarr")), Error);
}

TEST_F(IngestZarr, HeaderThatVanishes_IsNoArrayOfMissingChunks) {
  writeZarr(in("a.zarr"), few_);
  const std::unique_ptr<VolumeSource> source = openSource(in("a.zarr"));
  fs::remove_all(in("a.zarr"));
  test::expectError([&] { readWhole(*source); }, ErrorCode::kNotFound, "has gone while the array was read");
}

// Known: no product of the lengths fits into 64 bits, or into memory.
TEST_F(IngestZarr, HugeShapesAndChunksAreRefused) {
  const auto header = [](const char* shape, const char* chunks) {
    return fmt::format(R"({{"zarr_format": 2, "shape": {}, "chunks": {}, "dtype": "<u2", "compressor": null,
                            "fill_value": 0, "order": "C", "filters": null}})",
                       shape, chunks);
  };
  struct Case {
    const char *shape, *chunks, *part;
  };
  const Case cases[] = {
      {"[4611686018427387904, 4, 5]", "[1, 4, 5]", "shape: the array has more than 2^63 bytes"},
      {"[3, 4, 5]", "[4611686018427387904, 4, 5]", "chunk shape: a chunk has 2 GiB or more"},
      {"[3, 4, 5]", "[4294967296, 4294967296, 4294967296]", "chunk shape: a chunk has 2 GiB or more"},
      {"[9223372036854775808, 4, 5]", "[1, 4, 5]", "must be below 2^63"},
      {"[3, 4, -5]", "[1, 4, 5]", "lengths must be positive (found -5)"},
      {"[3, 4, 0]", "[1, 4, 5]", "lengths must be positive (found 0)"},
      {"[3, 4, 5]", "[1, 4, 0]", "lengths must be positive (found 0)"},
      {"[3, 4, 5]", "[1, 4]", "must have a number for each of 3 axes (found 2)"},
      {"[3, 4, 5.5]", "[1, 4, 5]", "must be a whole number"},
  };
  for (const Case& of : cases) {
    put("a.zarr/.zarray", header(of.shape, of.chunks));
    expectError("a.zarr", ErrorCode::kFormat, of.part);
  }
  // A shard of more chunks than any machine has memory for.
  put("b.zarr/zarr.json",
      R"({"zarr_format": 3, "node_type": "array", "shape": [8, 8, 8], "data_type": "uint8", "fill_value": 0,
          "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [1048576, 1048576, 8]}},
          "chunk_key_encoding": {"name": "default"}, "codecs": [{"name": "sharding_indexed", "configuration":
          {"chunk_shape": [1, 1, 1], "codecs": [{"name": "bytes"}], "index_codecs": [{"name": "bytes"}]}}]})");
  expectError("b.zarr", ErrorCode::kFormat, "a shard has more than 67 million chunks");
}

TEST_F(IngestZarr, ChunksThatLieAboutTheirSizeAreRefused) {
  writeZarr(in("raw.zarr"), few_);
  for (const std::size_t bytes : {0, 1, 47, 49, 100000}) {
    put("raw.zarr/0.0.0", std::string(bytes, 'x'));
    EXPECT_THROW(readWhole(*openSource(in("raw.zarr"))), Error) << bytes;
  }
  ZarrLayout zstd{.codec = ZarrCodec::kZstd};
  writeZarr(in("zstd.zarr"), few_, zstd);
  put("zstd.zarr/0.0.0", zstdFrame(std::string(1 << 20, '\0')));
  expectError("zstd.zarr", ErrorCode::kFormat, "0.0.0: the Zstandard data are damaged or too long (room for 48 bytes)");
  fs::resize_file(in("zstd.zarr/0.0.0"), std::uintmax_t{1} << 40);
  expectError("zstd.zarr", ErrorCode::kFormat, "has 1099511627776 bytes, and a chunk of 48 bytes has at most");
}

TEST_F(IngestZarr, IndexesOfShardsThatLieAreRefused) {
  ZarrLayout layout{.version = ZarrVersion::kThree};
  layout.chunks_in_shard = 2;
  writeZarr(in("a.zarr"), few_, layout);
  const std::string shard = bytesOf(in("a.zarr/c/0/0/0"));
  const std::size_t table_bytes = 16 * 8, table = shard.size() - table_bytes - 4;
  const auto lying = [&](std::uint64_t offset, std::uint64_t bytes) {
    const std::string lie =
        littleEndian(offset, 8) + littleEndian(bytes, 8) + shard.substr(table + 16, table_bytes - 16);
    put("a.zarr/c/0/0/0", shard.substr(0, table) + withCrc32c(lie));
  };
  const std::uint64_t most = UINT64_MAX;
  for (const auto& [offset, bytes] : std::vector<std::pair<std::uint64_t, std::uint64_t>>{
           {0, 0}, {0, most}, {most, 1}, {most - 40, 48}, {shard.size(), 48}, {shard.size() - 47, 48}, {0, 1 << 30}}) {
    lying(offset, bytes);
    expectError("a.zarr", ErrorCode::kFormat, "the shard's index");
  }
  put("a.zarr/c/0/0/0", shard.substr(0, table) + shard.substr(table, table_bytes) + "abcd");
  expectError("a.zarr", ErrorCode::kFormat, "index of the shard: the checksum (CRC-32C) differs");
  put("a.zarr/c/0/0/0", "short");
  expectError("a.zarr", ErrorCode::kFormat, "the file has 5 bytes, and the index alone has 132");
}

// Known: values take memory before a conversion is planned, so their length is held against the memory first.
TEST_F(IngestZarr, HeadersLargerThanTheMemory_areRefusedUnread) {
  SourceOptions options;
  options.memory_bytes = 20 << 20;
  const std::string comment = ", \"comment\": \"" + std::string(10 << 20, 'x') + "\"";
  putImage("a.zarr", few_, imageOf(axesOf("zyx"), kScale), comment);
  expectError("a.zarr", ErrorCode::kBudget, ".zattrs: --memory: the header takes up to", options);
  EXPECT_EQ(info("a.zarr").geometry.dims, few_.dims);
  options.memory_bytes = 200 << 20;
  EXPECT_EQ(info("a.zarr", options).geometry.dims, few_.dims);
  put("b.n5/attributes.json", "[" + comment.substr(13) + "]");
  options.memory_bytes = 20 << 20;
  expectError("b.n5", ErrorCode::kBudget, "attributes.json: --memory", options);
}

TEST_F(IngestZarr, HeadersThatAreNoHeadersAreRefused) {
  const auto expectHeader = [&](const std::string& text, const std::string& part, ErrorCode code = ErrorCode::kFormat) {
    put("a.zarr/zarr.json", text);
    expectError("a.zarr", code, part);
  };
  const auto array = [](const std::string& codecs, const std::string& type = "\"uint8\"") {
    return R"({"zarr_format": 3, "node_type": "array", "shape": [3, 4, 5], "fill_value": 0, "chunk_grid":
               {"name": "regular", "configuration": {"chunk_shape": [3, 4, 5]}}, "chunk_key_encoding":
               {"name": "default"}, "data_type": )" +
           type + ", \"codecs\": " + codecs + "}";
  };
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  expectHeader("", "is no JSON");
  expectHeader("[]", "must be an object");
  expectHeader(deep, "values lie more than 64 deep");
  expectHeader(array("[]", deep), "values lie more than 64 deep");
  expectHeader(R"({"zarr_format": 4})", "versions 2 and 3 of Zarr are read", ErrorCode::kUnsupported);
  expectHeader(array("[]"), "a codec of numbers (bytes, sharding_indexed) is missing");
  expectHeader(array(R"([{"name": "gzip"}, {"name": "bytes"}])"), "must come before codecs of bytes");
  expectHeader(array(R"([{"name": "bytes"}, {"name": "zfpy"}])"), "the codec 'zfpy' is not read",
               ErrorCode::kUnsupported);
  expectHeader(array(R"([{"name": "numcodecs.delta"}, {"name": "bytes"}])"), "the codec 'delta' is not read",
               ErrorCode::kUnsupported);
  expectHeader(array(R"([{"name": "bytes"}])", "\"complex64\""), "numbers of type 'complex64' are not read",
               ErrorCode::kUnsupported);
  expectHeader(array(R"([{"name": "transpose", "configuration": {"order": [0, 0, 1]}}, {"name": "bytes"}])"),
               "order: must name each axis once");
  expectHeader(array(R"([{"name": "transpose", "configuration": {"order": [0, 3, 1]}}, {"name": "bytes"}])"),
               "must name the axes of the array");
  expectHeader("[" + std::string(1 << 20, '0'), "is no JSON");
  std::string many = "[0";
  for (int i = 0; i < (1 << 18); ++i) many += ",0";
  expectHeader(many + "]", "has more than 262144 values");
}

// Consolidated metadata are copies, which programs forget to renew.
TEST_F(IngestZarr, ConsolidatedMetadataAreIgnored) {
  writeZarr(in("two.zarr"), few_);
  put("two.zarr/.zmetadata", "{damaged");
  expectReadsBack(few_, in("two.zarr"), 325);
  put("three.zarr/zarr.json",
      R"({"zarr_format": 3, "node_type": "group", "consolidated_metadata": {"kind": "inline", "metadata": {"0":
          {"zarr_format": 3, "node_type": "array", "shape": [1]}}}})");
  writeZarr(in("three.zarr/0"), few_, {.version = ZarrVersion::kThree});
  expectReadsBack(few_, in("three.zarr"), 326);
}

// Programs in Python write NaN without quotes in attributes.
TEST_F(IngestZarr, NumbersThatJsonLacksAreRead) {
  writeZarr(in("a.zarr"), few_);
  put("a.zarr/.zattrs", R"({"missing": NaN, "range": [-Infinity, Infinity], "text": "a \"NaN\" \\", "b": "Infinity"})");
  expectReadsBack(few_, in("a.zarr"), 327);
}

TEST_F(IngestZarr, N5_HasItsSizesAndPlaces) {
  const ZarrLayout n5{.version = ZarrVersion::kN5};
  put("a.n5/attributes.json", R"({"n5": "2.0.0"})");
  put("a.n5/raw/attributes.json",
      R"({"pixelResolution": {"unit": "um", "dimensions": [2, 3, 4]}, "offset": [1, 0, 0]})");
  writeZarr(in("a.n5/raw/s0"), few_, n5);
  ZarrLayout coarse = n5;
  coarse.more = R"(, "downsamplingFactors": [2, 2, 1])";
  const ForeignVolume half = randomVolume({3, 2, 3}, VoxelType::u16, 39);
  writeZarr(in("a.n5/raw/s1"), half, coarse);
  expectReadsBack(few_, in("a.n5/raw"), 328);
  expectReadsBack(few_, in("a.n5"), 329);
  expectReadsBack(
      half, [&] { return openSource(in("a.n5/raw"), withScale(1)); }, 330);
  expectError("a.n5/raw", ErrorCode::kUsage, "there is no array s2", withScale(2));
  for (const char* const spelling : {"a.n5/raw", "a.n5/raw/s0", "a.n5/raw/s0/"}) {
    EXPECT_EQ(info(spelling).geometry.worldOf({1, 1, 1}), glm::dvec3(3, 3, 4)) << spelling;
    EXPECT_EQ(info(spelling).geometry.unit, "um");
  }
  EXPECT_EQ(info("a.n5/raw/s1").geometry.worldOf({0, 0, 0}), glm::dvec3(2, 1.5, 0));
  EXPECT_EQ(info("a.n5/raw/s1").geometry.spacing(), glm::dvec3(4, 6, 4));
  // Another program's list of scales, without axes.
  put("a.n5/raw/attributes.json", R"({"multiscales": [{"datasets": [{"path": "s0"}, {"path": "s1"}]}],
                                      "resolution": [5, 6, 7]})");
  expectReadsBack(few_, in("a.n5/raw"), 331);
  EXPECT_EQ(info("a.n5/raw").geometry.spacing(), glm::dvec3(5, 6, 7));
}

// Known from the descriptions of n5-viewer (scales), neuroglancer (axes, units) and OpenOrganelle (transform).
TEST_F(IngestZarr, N5_HasTheAxesAndScalesOfEachFamilyOfPrograms) {
  ZarrLayout layout{.version = ZarrVersion::kN5};
  for (const char* const array : {"a.n5/s0", "a.n5/s1"}) writeZarr(in(array), few_, layout);
  put("a.n5/attributes.json", R"({"scales": [[1, 1, 1], [2, 4, 1]], "axes": ["x", "y", "z"], "resolution": [2, 3, 4],
                                  "units": ["nm", "nm", "um"]})");
  EXPECT_EQ(info("a.n5/s0").geometry.spacing(), glm::dvec3(2, 3, 4000));
  EXPECT_EQ(info("a.n5/s1").geometry.spacing(), glm::dvec3(4, 12, 4000));
  EXPECT_EQ(info("a.n5", withScale(1)).geometry.worldOf({0, 0, 0}), glm::dvec3(1, 4.5, 0));
  put("a.n5/attributes.json", R"({"downsamplingFactors": [[1, 1, 1], [2, 4, 1]], "resolution": [2, 3, 4]})");
  EXPECT_EQ(info("a.n5/s1").geometry.spacing(), glm::dvec3(4, 12, 4));
  put("a.n5/attributes.json", R"({"scales": [[1, 1, 1], [2, 4, 1]], "axes": ["x", "y", "z"]})");
  layout.more = R"(, "resolution": [4, 12, 4])";
  writeZarr(in("a.n5/s1"), few_, layout);
  EXPECT_EQ(info("a.n5/s1").geometry.spacing(), glm::dvec3(4, 12, 4)) << "a size of its own";

  layout.axes = {{'z', 2}, {'c', 1, 2, 1}, {'y', 3}, {'x', 4}};
  layout.more = R"(, "axes": ["x", "y", "c^", "z"])";
  expectReadsBack(
      few_, [&, folder = writeZarr(in("channels.n5"), few_, layout)] { return openSource(folder, withChannel("1")); },
      332);

  layout.axes = ZarrLayout().axes;
  const auto expectTransform = [&](const std::string& transform) {
    layout.more = R"(, "pixelResolution": {"dimensions": [9, 9, 9], "unit": "mm"}, "transform": )" + transform;
    writeZarr(in("organelle.n5/s1"), few_, layout);
    EXPECT_EQ(info("organelle.n5/s1").geometry.spacing(), glm::dvec3(2, 3, 4)) << transform;
    EXPECT_EQ(info("organelle.n5/s1").geometry.worldOf({0, 0, 0}), glm::dvec3(5, 6, 7)) << transform;
    EXPECT_EQ(info("organelle.n5/s1").geometry.unit, "nm") << transform;
  };
  expectTransform(R"({"axes": ["z", "y", "x"], "ordering": "C", "scale": [4, 3, 2], "translate": [7, 6, 5],
                      "units": ["nm", "nm", "nm"]})");
  expectTransform(R"({"axes": ["x", "y", "z"], "ordering": "F", "scale": [2, 3, 4], "translate": [5, 6, 7],
                      "units": ["nm", "nm", "nm"]})");
}

// Paintera writes several labels a voxel as blocks of bytes.
TEST_F(IngestZarr, LabelMultisetsOfN5_AreRefused) {
  writeZarr(in("a.n5"), randomVolume(kFewVoxels, VoxelType::u8, 41),
            {.version = ZarrVersion::kN5, .more = R"(, "isLabelMultiset": true)"});
  expectError("a.n5", ErrorCode::kUnsupported, "label multisets, several labels a voxel, are not read");
}

// A folder of slices beside another program's attributes.json is no container.
TEST_F(IngestZarr, FileNamedAttributesAlone_MakesNoContainer) {
  put("slices/attributes.json", R"({"patient": "anonymous"})");
  try {
    openSource(in("slices"));
    ADD_FAILURE() << "opened";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find("N5"), std::string::npos) << error.what();
  }
}

TEST_F(IngestZarr, FourThreadsReadAtOnce) {
  const ForeignVolume volume = randomVolume({40, 36, 9}, VoxelType::u16, 40);
  ZarrLayout layout{.version = ZarrVersion::kThree, .codec = ZarrCodec::kZstd};
  layout.chunks_in_shard = 2;
  const std::unique_ptr<VolumeSource> source = openSource(writeZarr(in("a.zarr"), volume, layout));
  expectThreadsReadBack(volume, *source);
  source->keepDecoded(0);
  expectThreadsReadBack(volume, *source);
}

// Every file of an array of one chunk or one shard: the header, the chunk, the shard with its index.
struct Victim {
  std::string name, file;
  ZarrLayout layout;
};

std::vector<Victim> victims() {
  ZarrLayout shards{.version = ZarrVersion::kThree, .codec = ZarrCodec::kZstd};
  shards.axes = {{'z', 2}, {'y', 2}, {'x', 3}};
  shards.chunks_in_shard = 2;
  ZarrLayout checked = shards;
  checked.checksum = checked.index_at_start = true;
  ZarrLayout blosc{.codec = ZarrCodec::kBlosc}, n5{.version = ZarrVersion::kN5, .codec = ZarrCodec::kLz4};
  blosc.axes = n5.axes = {{'z', 3}, {'y', 4}, {'x', 5}};
  return {{"v2", ".zarray", blosc},  {"v2", "0.0.0", blosc},      {"v3", "zarr.json", shards},
          {"v3", "c/0/0/0", shards}, {"v3c", "c/0/0/0", checked}, {"n5", "attributes.json", n5},
          {"n5", "0/0/0", n5}};
}

TEST_F(IngestZarr, EveryTruncationIsAnErrorOrExact) {
  for (const Victim& victim : victims()) {
    const std::string folder = victim.name + ".zarr", file = folder + "/" + victim.file;
    writeZarr(in(folder), few_, victim.layout);
    expectNoCutGoesUnnoticed(few_, files_, file, bytesOf(in(file)), in(folder));
  }
}

// Flips that a format without checksums cannot show may change voxels; all else is exact or one line of error.
TEST_F(IngestZarr, FlippedBitsAreHarmless) {
  for (const Victim& victim : victims()) {
    const std::string folder = victim.name + ".zarr", file = folder + "/" + victim.file;
    writeZarr(in(folder), few_, victim.layout);
    const std::string bytes = bytesOf(in(file));
    expectBitFlipsAreHarmless(files_, file, bytes, bytes.size(), in(folder), 332);
  }
}

}  // namespace
}  // namespace kiln::test
