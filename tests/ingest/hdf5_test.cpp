// HDF5. Known because the HDF5 library wrote the files, or because the compressors' own libraries encoded the chunks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <random>

#include "ingest/open_source.h"
#include "ingest/volume_list.h"
#include "support/files/foreign_files.h"
#include "support/files/hdf5_files.h"
#include "support/files/packed_bytes.h"

namespace kiln::test {
namespace {

namespace fs = std::filesystem;

constexpr Extent3 kDims = {13, 11, 9};
const std::vector<std::uint64_t> kChunk = {4, 5, 6};

fs::path part(const fs::path& file, const std::string& path) { return file.string() + ":" + path; }

// Blocks of `block` bytes behind the total and the block's size: the form of HDF5's LZ4 filter and of bitshuffle.
std::string lz4Blocks(const std::string& bytes, std::size_t block) {
  std::string out = bigEndian(bytes.size(), 8) + bigEndian(block, 4);
  for (std::size_t at = 0; at < bytes.size(); at += block) {
    const std::string packed = lz4Block(bytes.substr(at, block));
    const bool kept = packed.size() >= std::min(block, bytes.size() - at);
    const std::string& piece = kept ? bytes.substr(at, block) : packed;
    out += bigEndian(piece.size(), 4) + piece;
  }
  return out;
}

// Plane 8·b + k of a block has bit k of byte b of each number. Written bit by bit.
std::string bitPlanes(const std::string& bytes, std::size_t size) {
  const std::size_t count = bytes.size() / size;
  std::string out(bytes.size(), '\0');
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t b = 0; b < size; ++b)
      for (std::size_t k = 0; k < 8; ++k)
        if (static_cast<unsigned char>(bytes[i * size + b]) >> k & 1)
          out[(b * 8 + k) * (count / 8) + i / 8] |= static_cast<char>(1u << (i % 8));
  return out;
}

// Blocks of `block` numbers, a shorter block of a multiple of eight, and the rest as it is.
std::string bitshuffled(const std::string& bytes, std::size_t size, std::size_t block, bool compressed) {
  std::string out = compressed ? bigEndian(bytes.size(), 8) + bigEndian(block * size, 4) : "";
  std::size_t at = 0;
  while (bytes.size() - at >= 8 * size) {
    const std::size_t numbers = std::min(block, (bytes.size() - at) / size / 8 * 8);
    const std::string planes = bitPlanes(bytes.substr(at, numbers * size), size);
    out += compressed ? bigEndian(lz4Block(planes).size(), 4) + lz4Block(planes) : planes;
    at += numbers * size;
  }
  return out + bytes.substr(at);
}

// Literal runs of up to 32 bytes, and one copy of the bytes before where eight bytes repeat.
std::string lzfOf(const std::string& bytes) {
  std::string out;
  std::size_t at = 0;
  while (at < bytes.size()) {
    const bool repeats = at >= 8 && at + 8 <= bytes.size() && bytes.compare(at, 8, bytes, at - 8, 8) == 0;
    if (repeats) {
      // Length 8 is 6 + 2, in three bits; distance 8 is written less one.
      out += {static_cast<char>(6 << 5), 7};
      at += 8;
      continue;
    }
    const std::size_t count = std::min<std::size_t>(at < 8 ? 8 : 1, bytes.size() - at);
    out.push_back(static_cast<char>(count - 1));
    out += bytes.substr(at, count);
    at += count;
  }
  return out;
}

TEST(IngestHdf5, EveryTypeAndOrderReadsBack) {
  const ForeignFiles files;
  const fs::path file = files.directory() / "a.h5";
  std::vector<std::pair<std::string, ForeignVolume>> volumes;
  {
    Hdf5File out(file);
    for (const VoxelType type : kAllTypes) {
      const ForeignVolume volume = randomVolume(kDims, type, 401);
      for (const bool big_endian : {false, true}) {
        const std::string name = "/" + std::string(nameOf(type)) + (big_endian ? "be" : "le");
        out.add(name + "/contiguous", volume, {.big_endian = big_endian});
        out.add(name + "/chunked", volume, {.chunk = kChunk, .big_endian = big_endian, .deflate = 4});
        volumes.emplace_back(name + "/contiguous", volume);
        volumes.emplace_back(name + "/chunked", volume);
      }
    }
  }
  for (const auto& [path, volume] : volumes) {
    SCOPED_TRACE(path);
    if (volume.type == VoxelType::u8 || volume.type == VoxelType::f64)
      expectReadsBack(volume, part(file, path), 402);
    else
      EXPECT_TRUE(readWhole(*openSource(part(file, path))) == volume.voxels);
  }
}

TEST(IngestHdf5, EveryFilterOfTheLibraryReadsBack) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kDims, VoxelType::u16, 411);
  const fs::path file = files.directory() / "a.h5";
  const std::pair<const char*, Hdf5Dataset> datasets[] = {
      {"/plain", {.chunk = kChunk}},
      {"/large", {.chunk = {9, 11, 13}}},
      {"/deflate", {.chunk = kChunk, .deflate = 9}},
      {"/shuffle", {.chunk = kChunk, .shuffle = true, .deflate = 1}},
      {"/checked", {.chunk = kChunk, .shuffle = true, .fletcher32 = true, .deflate = 1}},
      {"/raw_border", {.chunk = kChunk, .shuffle = true, .raw_border = true, .deflate = 1}},
      {"/odd_checked", {.chunk = {1, 1, 3}, .fletcher32 = true}},
      {"/scaled", {.chunk = kChunk, .scale_offset = true}},
      {"/compact", {.compact = true}},
  };
  {
    Hdf5File out(file);
    for (const auto& [path, dataset] : datasets) out.add(path, volume, dataset);
  }
  for (const auto& [path, dataset] : datasets) {
    SCOPED_TRACE(path);
    expectReadsBack(volume, part(file, path), 412);
  }
}

TEST(IngestHdf5, EveryRegisteredFilterReadsBack) {
  const ForeignFiles files;
  // Every other voxel repeats, so that compressors have something to save.
  ForeignVolume volume = randomVolume(kDims, VoxelType::u16, 421);
  for (std::size_t i = 0; i + 16 <= volume.voxels.size(); i += 32)
    std::copy_n(volume.voxels.begin() + static_cast<std::ptrdiff_t>(i), 8,
                volume.voxels.begin() + static_cast<std::ptrdiff_t>(i) + 8);
  std::vector<std::pair<std::string, Hdf5Dataset>> datasets;
  const auto add = [&](const std::string& name, int id, std::vector<unsigned> values, auto encode) {
    datasets.emplace_back("/" + name,
                          Hdf5Dataset{.chunk = kChunk, .foreign = Hdf5Filter{id, std::move(values)}, .encode = encode});
  };
  add("lzf", 32000, {4, 261, 240}, lzfOf);
  add("lz4", 32004, {64}, [](const std::string& chunk) { return lz4Blocks(chunk, 64); });
  add("lz4_one", 32004, {}, [](const std::string& chunk) { return lz4Blocks(chunk, 4096); });
  add("zstd", 32015, {3}, [](const std::string& chunk) { return zstdFrame(chunk); });
  const std::pair<const char*, unsigned> blosc_codecs[] = {
      {"blosclz", 0}, {"lz4", 1}, {"lz4hc", 2}, {"zlib", 4}, {"zstd", 5}};
  for (const auto& [codec, number] : blosc_codecs) {
    for (const int shuffle : {0, 1, 2}) {
      const BloscSpec spec{.codec = codec, .shuffle = shuffle};
      add(std::string("blosc_") + codec + std::to_string(shuffle), 32001,
          {2, 2, 2, 240, 5, static_cast<unsigned>(shuffle), number},
          [=](const std::string& chunk) { return bloscFrame(chunk, spec); });
    }
  }
  add("blosc_default", 32001, {2, 2}, [](const std::string& chunk) { return bloscFrame(chunk, {.codec = "blosclz"}); });
  add("bitshuffle", 32008, {0, 4, 2, 16, 0}, [](const std::string& chunk) { return bitshuffled(chunk, 2, 16, false); });
  add("bitshuffle_default", 32008, {0, 4, 2, 0, 0},
      [](const std::string& chunk) { return bitshuffled(chunk, 2, 4096, false); });
  add("bitshuffle_lz4", 32008, {0, 4, 2, 16, 2},
      [](const std::string& chunk) { return bitshuffled(chunk, 2, 16, true); });
  const fs::path file = files.directory() / "a.h5";
  {
    Hdf5File out(file);
    for (const auto& [path, dataset] : datasets) out.add(path, volume, dataset);
  }
  for (const auto& [path, dataset] : datasets) {
    SCOPED_TRACE(path);
    expectReadsBack(volume, part(file, path), 422);
  }
}

// Known: chunks of 9 x 7 x 1 numbers are no multiple of eight, so the last numbers are not shuffled.
TEST(IngestHdf5, NumbersBehindTheLastBitPlaneReadBack) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({9, 7, 5}, VoxelType::f32, 431);
  const fs::path file = files.directory() / "a.h5";
  Hdf5File(file).add("/v", volume,
                     {.chunk = {1, 7, 9},
                      .foreign = Hdf5Filter{32008, {0, 4, 4, 8, 2}},
                      .encode = [](const std::string& chunk) { return bitshuffled(chunk, 4, 8, true); }});
  expectReadsBack(volume, file, 432);
}

TEST(IngestHdf5, VirtualDataAndUserBlocksReadBack) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kDims, VoxelType::u16, 441);
  Hdf5File(files.directory() / "source.h5").add("/v", volume, {.chunk = kChunk, .deflate = 1});
  Hdf5File(files.directory() / "virtual.h5").addVirtual("/v", kDims, (files.directory() / "source.h5").string(), "/v");
  expectReadsBack(volume, files.directory() / "virtual.h5", 442);
  for (const bool chunked : {false, true}) {
    const fs::path file = files.directory() / "block.h5";
    Hdf5File(file, 512).add("/v", volume, {.chunk = chunked ? kChunk : std::vector<std::uint64_t>()});
    expectReadsBack(volume, file, 443);
  }
}

TEST(IngestHdf5, VirtualDataOfAMissingFile_areRefused) {
  const ForeignFiles files;
  const fs::path file = files.directory() / "virtual.h5";
  Hdf5File(file).addVirtual("/v", kDims, "source.h5", "/v");
  expectRefused(file, ErrorCode::kNotFound, "'source.h5' with voxels of this data set is missing");
  const ForeignVolume volume = randomVolume(kDims, VoxelType::u16, 444);
  Hdf5File(files.directory() / "source.h5").add("/v", volume);
  EXPECT_TRUE(readWhole(*openSource(file)) == volume.voxels);
  const fs::path below = files.directory() / "below.h5";
  Hdf5File(below).addVirtual("/v", kDims, "sub/source.h5", "/v");
  expectRefused(below, ErrorCode::kNotFound, "'sub/source.h5' with voxels of this data set is missing");
  fs::create_directory(files.directory() / "linked");
  fs::create_symlink(file, files.directory() / "linked/virtual.h5");
  EXPECT_TRUE(readWhole(*openSource(files.directory() / "linked/virtual.h5")) == volume.voxels);
}

TEST(IngestHdf5, ChunksThatWereNeverWritten_areTheFillValue) {
  const ForeignFiles files;
  ForeignVolume volume = randomVolume(kDims, VoxelType::i16, 451);
  for (std::size_t i = 0; i < volume.voxels.size(); i += 2)
    volume.voxels[i] = std::byte{0xfe}, volume.voxels[i + 1] = std::byte{0xff};
  const fs::path file = files.directory() / "a.h5";
  Hdf5File(file).add("/v", volume, {.chunk = kChunk, .deflate = 1, .fill = -2, .written = false});
  EXPECT_TRUE(readWhole(*openSource(file)) == volume.voxels);
}

TEST(IngestHdf5, SeveralThreadsReadAtOnce) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({40, 30, 20}, VoxelType::u16, 461);
  const fs::path file = files.directory() / "a.h5";
  {
    Hdf5File out(file);
    out.add("/here", volume, {.chunk = {8, 8, 8}, .shuffle = true, .deflate = 1});
    out.add("/served", volume, {.chunk = {8, 8, 8}, .scale_offset = true});
  }
  for (const char* const path : {"/here", "/served"}) expectThreadsReadBack(volume, *openSource(part(file, path)));
}

TEST(IngestHdf5, SeveralVolumesAreListed) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kDims, VoxelType::u16, 471);
  const fs::path file = files.directory() / "a.h5";
  {
    Hdf5File out(file);
    out.add("/one", volume);
    out.add("/two/deep", volume);
    out.addNumbers("/list", {1, 2, 3});
  }
  expectRefused(file, ErrorCode::kUsage,
                "holds 2 data sets: /one (9, 11, 13) uint16; /two/deep (9, 11, 13) uint16; name one, as " +
                    file.string() + ":/one");
  expectReadsBack(volume, part(file, "/two/deep"), 472);
  expectRefused(part(file, "/three"), ErrorCode::kNotFound, "/three: there is no data set of this name");
  expectRefused(part(file, "/two"), ErrorCode::kNotFound, "/two: is no data set of numbers");
  expectRefused(part(file, "/list"), ErrorCode::kUnsupported, "fewer than two axes");
  SourceOptions options;
  options.scale = 1;
  expectRefused(part(file, "/one"), ErrorCode::kUsage, "--scale", options);
}

// Known: the description holds 256 texts of 16 KiB.
TEST(IngestHdf5, DescriptionLargerThanTheMemory_isRefused) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kDims, VoxelType::u16, 473);
  const fs::path file = files.directory() / "a.h5";
  {
    Hdf5File out(file);
    out.add("/one", volume);
    for (int i = 0; i < 256; ++i) {
      const std::string group = "/g" + std::to_string(i);
      out.addGroup(group);
      out.setText(group, "note", std::string(16 << 10, 'x'));
    }
  }
  SourceOptions options;
  for (const std::uint64_t mib : {2, 8}) {
    options.memory_bytes = mib << 20;
    expectRefused(file, ErrorCode::kBudget, "a.h5: --memory: the header takes up to", options);
  }
  options.memory_bytes = 16 << 20;
  expectReadsBack(
      volume, [&] { return openSource(file, options); }, 474);
  options.memory_bytes = 2 << 20;
  expectError([&] { volumesIn(file, options); }, ErrorCode::kBudget, "a.h5: --memory");
}

// Known: the last three axes are z, y, x; an axis in front is chosen by a number.
TEST(IngestHdf5, AxesInFrontAreChannelsAndTimes) {
  const ForeignFiles files;
  const ForeignVolume both = randomVolume({5, 4, 6}, VoxelType::u16, 481);
  const fs::path file = files.directory() / "a.h5";
  {
    Hdf5File out(file);
    out.add("/chunked", both, {.shape = {2, 3, 4, 5}, .chunk = {2, 2, 3, 4}});
    out.add("/contiguous", both, {.shape = {2, 3, 4, 5}});
  }
  for (const char* const path : {"/chunked", "/contiguous"}) {
    SCOPED_TRACE(path);
    expectRefused(part(file, path), ErrorCode::kUsage, "holds 2 channels; choose one with --channel");
    for (const std::int64_t i : {0, 1}) {
      SourceOptions by_channel, by_time;
      by_channel.channel = std::to_string(i);
      by_time.time = i;
      const ForeignVolume expected = both.part({{0, 0, 3 * i}, {5, 4, 3 * i + 3}});
      for (const SourceOptions& options : {by_channel, by_time})
        expectReadsBack(
            expected, [&] { return openSource(part(file, path), options); }, 482);
    }
  }
}

glm::dvec3 at(const VolumeSource& source, const glm::dvec3& index) { return source.info().geometry.worldOf(index); }

TEST(IngestHdf5, ImarisHasExtentsAndPaddedData) {
  const ForeignFiles files;
  const fs::path file = files.directory() / "a.ims";
  const ForeignVolume padded = randomVolume({8, 8, 8}, VoxelType::u8, 491),
                      other = randomVolume({8, 8, 8}, VoxelType::u8, 492);
  const std::string time = "/DataSet/ResolutionLevel 0/TimePoint 0";
  {
    Hdf5File out(file);
    out.add(time + "/Channel 0/Data", padded, {.chunk = {4, 4, 4}, .deflate = 2});
    out.add(time + "/Channel 1/Data", other, {.chunk = {4, 4, 4}, .deflate = 2});
    for (const char* const channel : {"/Channel 0", "/Channel 1"}) {
      out.setLetters(time + channel, "ImageSizeX", "5");
      out.setLetters(time + channel, "ImageSizeY", "6");
      out.setLetters(time + channel, "ImageSizeZ", "7");
    }
    for (const char* const group : {"/DataSetInfo/Image", "/DataSetInfo/Channel 0", "/DataSetInfo/Channel 1"})
      out.addGroup(group);
    const char* const low[] = {"10", "0", "-7"};
    const char* const high[] = {"20", "3", "0"};
    for (int i = 0; i < 3; ++i) {
      out.setLetters("/DataSetInfo/Image", "ExtMin" + std::to_string(i), low[i]);
      out.setLetters("/DataSetInfo/Image", "ExtMax" + std::to_string(i), high[i]);
    }
    out.setLetters("/DataSetInfo/Image", "Unit", "um");
    out.setLetters("/DataSetInfo/Channel 0", "Name", "DAPI");
    out.setLetters("/DataSetInfo/Channel 1", "Name", "GFP");
  }
  expectRefused(file, ErrorCode::kUsage, "holds 2 channels");
  SourceOptions options;
  options.channel = "GFP";
  const auto source = openSource(file, options);
  EXPECT_TRUE(readWhole(*source) == other.box({{0, 0, 0}, {5, 6, 7}}));
  // Voxels of 2 x 0.5 x 1; the first is centred half a voxel behind the extent's begin.
  EXPECT_EQ(at(*source, {0, 0, 0}), glm::dvec3(11, 0.25, -6.5));
  EXPECT_EQ(at(*source, {1, 1, 1}), glm::dvec3(13, 0.75, -5.5));
  EXPECT_EQ(source->info().geometry.unit, "um");
  const auto named = openSource(part(file, time + "/Channel 1/Data"));
  EXPECT_TRUE(readWhole(*named) == other.box({{0, 0, 0}, {5, 6, 7}}));
  EXPECT_EQ(named->info().geometry.world_from_index, source->info().geometry.world_from_index);
  EXPECT_EQ(volumesIn(file, {}).at(0).dims, (Extent3{5, 6, 7}));
  // The library takes a doubled slash as one.
  EXPECT_EQ(openSource(part(file, time + "/Channel 1//Data"))->info().geometry.dims, (Extent3{8, 8, 8}));
}

TEST(IngestHdf5, BigDataViewerHasItsAffineAndUnsignedNumbers) {
  const ForeignFiles files;
  const fs::path file = files.directory() / "a.h5";
  const ForeignVolume fine = randomVolume({6, 5, 4}, VoxelType::i16, 501),
                      coarse = randomVolume({3, 5, 4}, VoxelType::i16, 502);
  {
    Hdf5File out(file);
    out.addNumbers("/s00/resolutions", {1, 1, 1, 2, 1, 1}, {2, 3});
    out.add("/t00000/s00/0/cells", fine, {.chunk = {2, 2, 2}, .deflate = 1});
    out.add("/t00000/s00/1/cells", coarse, {.chunk = {2, 2, 2}, .deflate = 1});
  }
  files.write("a.xml",
              R"(<?xml version="1.0"?><SpimData><SequenceDescription><ViewSetups><ViewSetup><id>0</id><name>red</name>
    <voxelSize><unit>micrometer</unit><size>1 1 1</size></voxelSize></ViewSetup></ViewSetups></SequenceDescription>
    <ViewRegistrations><ViewRegistration timepoint="0" setup="0">
    <ViewTransform type="affine"><affine>1 0 0 10 0 1 0 20 0 0 1 30</affine></ViewTransform>
    <ViewTransform type="affine"><affine>2 0 0 0 0 3 0 0 0 0 4 0</affine></ViewTransform>
    </ViewRegistration></ViewRegistrations></SpimData>)");
  const auto source = openSource(file);
  EXPECT_EQ(source->info().type, VoxelType::u16);
  EXPECT_TRUE(readWhole(*source) == fine.voxels);
  // The second transformation scales first, the first then moves.
  EXPECT_EQ(at(*source, {1, 1, 1}), glm::dvec3(12, 23, 34));
  EXPECT_EQ(source->info().geometry.unit, "um");
  const auto by_description = openSource(files.directory() / "a.xml");
  EXPECT_TRUE(readWhole(*by_description) == fine.voxels);
  const std::vector<ListedVolume> listed = volumesIn(files.directory() / "a.xml", {});
  ASSERT_EQ(listed.size(), 2u);
  EXPECT_EQ(listed[0].type, VoxelType::u16);
  EXPECT_EQ(listed[1].dims, coarse.dims);
  EXPECT_EQ(volumesIn(files.directory(), {}).size(), 2u);
  expectRefused(files.write("b.xml", "<SpimData/>"), ErrorCode::kNotFound, "'b.h5', is missing");
  SourceOptions options;
  options.scale = 1;
  const auto small = openSource(file, options);
  EXPECT_TRUE(readWhole(*small) == coarse.voxels);
  // A voxel of level 1 covers two of level 0 along x, and lies between them.
  EXPECT_EQ(at(*small, {0, 0, 0}), at(*source, {0.5, 0, 0}));
  EXPECT_EQ(at(*small, {1, 1, 1}), at(*source, {2.5, 1, 1}));
  options.scale = 2;
  expectRefused(file, ErrorCode::kUsage, "--scale: must be a number from 0 to 1", options);
  // A path chooses nothing else than the options do.
  const auto named = openSource(part(file, "/t00000/s00/1/cells"));
  EXPECT_EQ(named->info().type, VoxelType::u16);
  EXPECT_EQ(named->info().geometry.world_from_index, small->info().geometry.world_from_index);
}

TEST(IngestHdf5, NexusNamesItsSignalAndAxes) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({4, 3, 5}, VoxelType::f32, 511);
  const fs::path file = files.directory() / "a.nxs";
  {
    Hdf5File out(file);
    out.add("/entry/result/data", volume);
    out.add("/entry/raw/data", volume);
    out.addNumbers("/entry/result/z", {0, 2, 4, 6, 8});
    out.addNumbers("/entry/result/y", {5, 6, 7});
    out.addNumbers("/entry/result/x", {0, 0.5, 1, 1.5});
    out.setText("/", "default", "entry");
    out.setText("/entry", "default", "result");
    out.setText("/entry/result", "signal", "data");
    out.setTexts("/entry/result", "axes", {"z", "y", "x"});
  }
  const auto source = openSource(file);
  EXPECT_TRUE(readWhole(*source) == volume.voxels);
  EXPECT_EQ(at(*source, {0, 0, 0}), glm::dvec3(0, 5, 0));
  EXPECT_EQ(at(*source, {1, 1, 1}), glm::dvec3(0.5, 6, 2));
}

// Coordinates that are not one for each voxel place nothing.
TEST(IngestHdf5, NexusCoordinatesOfAnotherLength_areNotUsed) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({4, 3, 5}, VoxelType::u8, 519);
  const fs::path file = files.directory() / "a.nxs";
  {
    Hdf5File out(file);
    out.add("/entry/data", volume);
    out.addNumbers("/entry/z", {0, 2, 4, 6, 8});
    out.addNumbers("/entry/y", {5, 6, 7});
    out.addNumbers("/entry/x", {0, 0.5, 1});
    out.setText("/", "default", "entry");
    out.setText("/entry", "signal", "data");
    out.setTexts("/entry", "axes", {"z", "y", "x"});
  }
  const auto source = openSource(file);
  EXPECT_EQ(source->info().geometry.spacing().x, 1);
  const std::vector<std::string>& notes = source->info().notes;
  EXPECT_TRUE(std::find(notes.begin(), notes.end(),
                        "the coordinates /entry/x are 3 numbers for 4 voxels and are not used") != notes.end());
}

// A NeXus file of 4 x 3 x 5 voxels; coordinates without entries are left out.
struct NexusCoordinates {
  std::vector<double> x, y, z;
};

void writeNexus(const fs::path& file, const ForeignVolume& volume, const NexusCoordinates& coordinates) {
  Hdf5File out(file);
  out.add("/entry/data", volume);
  const std::pair<const char*, std::vector<double>> lists[] = {
      {"/entry/z", coordinates.z}, {"/entry/y", coordinates.y}, {"/entry/x", coordinates.x}};
  for (const auto& [path, numbers] : lists) {
    if (numbers.empty()) continue;
    out.addNumbers(path, numbers);
    out.setText(path, "units", "mm");
  }
  out.setText("/", "default", "entry");
  out.setText("/entry", "signal", "data");
  out.setTexts("/entry", "axes", {"z", "y", "x"});
}

// Known: the coordinates of y fall, so that its step is negative.
TEST(IngestHdf5, NexusCoordinatesThatFall_areANegativeStep) {
  const ForeignFiles files;
  const fs::path file = files.directory() / "a.nxs";
  writeNexus(file, randomVolume({4, 3, 5}, VoxelType::u8, 526), {{0, 0.5, 1, 1.5}, {2.5, 1.25, 0}, {0, 3, 6, 9, 12}});
  const auto source = openSource(file);
  EXPECT_EQ(at(*source, {0, 0, 0}), glm::dvec3(0, 2.5, 0));
  EXPECT_EQ(at(*source, {1, 2, 1}), glm::dvec3(0.5, 0, 3));
  EXPECT_TRUE(source->info().notes.empty()) << source->info().notes.front();
}

TEST(IngestHdf5, NexusCoordinatesThatAreUnequalOrMissing_areNotedByTheirAxis) {
  const ForeignFiles files;
  const fs::path file = files.directory() / "a.nxs";
  writeNexus(file, randomVolume({4, 3, 5}, VoxelType::u8, 527), {{}, {0, 1.25, 2.5}, {0, 3, 7, 9, 12}});
  const auto source = openSource(file);
  EXPECT_EQ(source->info().geometry.spacing(), glm::dvec3(1, 1.25, 3));
  EXPECT_EQ(source->info().geometry.unit, "mm");
  const std::vector<std::string>& notes = source->info().notes;
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_NE(notes[0].find("/entry/z are not equally spaced; their mean distance, 3 mm"), std::string::npos) << notes[0];
  EXPECT_NE(notes[1].find("along the axis 'x', which is taken as 1 mm"), std::string::npos) << notes[1];
}

// Known: Tomviz writes the axes as x, y, z, and nanometres as [n_m].
TEST(IngestHdf5, EmdNamesItsAxes) {
  const ForeignFiles files;
  const ForeignVolume stored = randomVolume({5, 3, 4}, VoxelType::u8, 528);
  const auto write = [&](const std::string& name, const std::vector<std::string>& names) {
    Hdf5File out(files.directory() / name);
    out.add("/data/tomography/data", stored);
    const std::vector<double> numbers[] = {{0, 0.5, 1, 1.5}, {0, 2, 4}, {0, 3, 6, 9, 12}};
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string dim = "/data/tomography/dim" + std::to_string(i + 1);
      out.addNumbers(dim, numbers[i]);
      out.setText(dim, "name", names[i]);
      out.setText(dim, "units", "[n_m]");
    }
  };
  write("a.emd", {"x", "y", "z"});
  const auto source = openSource(files.directory() / "a.emd");
  EXPECT_EQ(source->info().geometry.dims, (Extent3{4, 3, 5}));
  EXPECT_EQ(source->info().geometry.spacing(), glm::dvec3(0.5, 2, 3));
  EXPECT_EQ(source->info().geometry.unit, "nm");
  EXPECT_EQ(readWhole(*source)[1], stored.voxels[15]);
  // Names of other axes place nothing: the last axis is x.
  write("b.emd", {"x", "y", "angles"});
  EXPECT_TRUE(readWhole(*openSource(files.directory() / "b.emd")) == stored.voxels);
}

// Known: the axes of the data set are x, y, z, so that the library gives what a raw file could not.
TEST(IngestHdf5, ContiguousDataOfOtherAxesOrTypesReadBack) {
  const ForeignFiles files;
  const ForeignVolume stored = randomVolume({5, 3, 4}, VoxelType::u16, 516);
  const fs::path file = files.directory() / "a.nxs";
  {
    Hdf5File out(file);
    out.add("/entry/data", stored, {.big_endian = true});
    out.setText("/", "default", "entry");
    out.setText("/entry", "signal", "data");
    out.setTexts("/entry", "axes", {"x", "y", "z"});
  }
  ForeignVolume turned = {{4, 3, 5}, VoxelType::u16, std::vector<std::byte>(stored.voxels.size())};
  for (std::int64_t z = 0; z < 5; ++z)
    for (std::int64_t y = 0; y < 3; ++y)
      for (std::int64_t x = 0; x < 4; ++x)
        std::copy_n(stored.voxels.begin() + ((x * 3 + y) * 5 + z) * 2, 2,
                    turned.voxels.begin() + ((z * 3 + y) * 4 + x) * 2);
  expectReadsBack(turned, file, 517);
}

// Known: the names of the axes are "time" and those of space, in any order and in capital letters.
TEST(IngestHdf5, AxisNamedTime_isATime) {
  const ForeignFiles files;
  const ForeignVolume both = randomVolume({5, 4, 6}, VoxelType::u16, 518);
  const fs::path file = files.directory() / "a.nxs";
  {
    Hdf5File out(file);
    out.add("/entry/data", both, {.shape = {2, 3, 4, 5}});
    out.setText("/", "default", "entry");
    out.setText("/entry", "signal", "data");
    out.setTexts("/entry", "axes", {"Time", "Z", "Y", "X"});
  }
  SourceOptions options;
  options.time = 1;
  EXPECT_TRUE(readWhole(*openSource(file, options)) == both.box({{0, 0, 3}, {5, 4, 6}}));
}

// Known: a text of the data set names its axes, as NeXus did before 2014.
TEST(IngestHdf5, AxesOfAnOldNexusFile_stayInTheirOrder) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({4, 3, 5}, VoxelType::u8, 533);
  const fs::path file = files.directory() / "a.nxs";
  for (const char* const axes : {"z:y:x", "[z,y,x]"}) {
    {
      Hdf5File out(file);
      out.add("/entry/data", volume);
      out.addNumbers("/entry/z", {0, 2, 4, 6, 8});
      out.setText("/entry/data", "axes", axes);
    }
    const auto source = openSource(file);
    EXPECT_TRUE(readWhole(*source) == volume.voxels);
    EXPECT_EQ(source->info().geometry.spacing(), glm::dvec3(1, 1, 2));
  }
}

// Known: "." stands for an axis without coordinates; Fortran pads texts with spaces.
TEST(IngestHdf5, NexusAxesMayHaveNoNameOrPaddedNames) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({4, 3, 5}, VoxelType::u8, 534);
  const fs::path file = files.directory() / "a.nxs";
  const auto write = [&](const std::vector<std::string>& axes, bool padded) {
    Hdf5File out(file);
    out.add("/entry/data", volume);
    out.addNumbers("/entry/frame", {0, 2, 4, 6, 8});
    out.addNumbers("/entry/x", {0, 3, 6, 9});
    if (padded)
      out.setPaddedTexts("/entry", "axes", axes);
    else
      out.setTexts("/entry", "axes", axes);
  };
  write({"frame", ".", "."}, false);
  EXPECT_TRUE(readWhole(*openSource(file)) == volume.voxels);
  EXPECT_EQ(openSource(file)->info().geometry.spacing(), glm::dvec3(1, 1, 2));
  write({"z", "y", "x"}, true);
  EXPECT_EQ(openSource(file)->info().geometry.spacing(), glm::dvec3(3, 1, 1));
}

// Known: edges are one more than voxels; a voxel lies between two of them.
TEST(IngestHdf5, NexusCoordinatesOfEdges_placeTheCentres) {
  const ForeignFiles files;
  const fs::path file = files.directory() / "a.nxs";
  writeNexus(file, randomVolume({4, 3, 5}, VoxelType::u8, 535), {{1, 3, 5, 7, 9}, {0, 1, 2}, {0, -1, -2, -3, -4, -5}});
  const auto source = openSource(file);
  EXPECT_EQ(at(*source, {0, 0, 0}), glm::dvec3(2, 0, -0.5));
  EXPECT_EQ(at(*source, {1, 1, 1}), glm::dvec3(4, 1, -1.5));
  EXPECT_TRUE(source->info().notes.empty()) << source->info().notes.front();
}

// Known: NetCDF gives each dimension the name of its coordinates; a dimension without coordinates places nothing.
TEST(IngestHdf5, DimensionScalesAreCoordinates) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({4, 3, 5}, VoxelType::f32, 536);
  const fs::path file = files.directory() / "a.nc";
  const auto write = [&](const std::vector<std::string>& scales) {
    Hdf5File out(file);
    out.add("/temperature", volume);
    out.addNumbers("/depth", {10, 15, 20, 25, 30});
    out.addNumbers("/y", {0, 2, 4});
    out.addNumbers("/z", {0, 2, 4});
    out.addNumbers("/x", {0, 1, 2, 3});
    for (const char* const scale : {"/depth", "/y", "/z", "/x"}) out.setText(scale, "units", "m");
    out.setScales("/temperature", scales);
  };
  write({"/depth", "/y", "/x"});
  const auto source = openSource(file);
  EXPECT_TRUE(readWhole(*source) == volume.voxels);
  EXPECT_EQ(at(*source, {1, 1, 1}), glm::dvec3(1, 2, 15));
  EXPECT_EQ(source->info().geometry.unit, "m");
  write({"/depth", "", "/x"});
  EXPECT_EQ(openSource(file)->info().geometry.spacing(), glm::dvec3(1, 1, 5));
  EXPECT_EQ(openSource(file)->info().notes.at(0),
            "no coordinates give a distance along the axis 1, which is taken as 1 m; --spacing sets another size");
}

// Known: the test writes two times of a volume, and its dimension scales.
TEST(IngestHdf5, DimensionScalesMayBeTimesAndChannels) {
  const ForeignFiles files;
  const ForeignVolume both = randomVolume({5, 4, 6}, VoxelType::u16, 540);
  const fs::path file = files.directory() / "a.nc";
  const auto write = [&](const std::vector<std::string>& scales) {
    Hdf5File out(file);
    out.add("/v", both, {.shape = {2, 3, 4, 5}});
    const std::size_t counts[] = {2, 3, 4, 5};
    for (std::size_t axis = 0; axis < 4; ++axis) {
      std::vector<double> numbers;
      for (std::size_t i = 0; i < counts[axis]; ++i) numbers.push_back(static_cast<double>((axis + 1) * i));
      if (!scales[axis].empty()) out.addNumbers(scales[axis], numbers);
    }
    out.setScales("/v", scales);
  };
  SourceOptions time, channel;
  time.time = 1;
  channel.channel = "1";
  const auto expectRead = [&](const SourceOptions& options, const glm::dvec3& spacing) {
    const auto source = openSource(file, options);
    EXPECT_TRUE(readWhole(*source) == both.box({{0, 0, 3}, {5, 4, 6}}));
    EXPECT_EQ(source->info().geometry.spacing(), spacing);
  };
  write({"/time", "/z", "/y", "/x"});
  expectRead(time, {4, 3, 2});
  expectRefused(file, ErrorCode::kUsage, "2 times");
  write({"/Time", "/depth", "/lat", "/lon"});
  expectRead(time, {4, 3, 2});
  expectRefused(file, ErrorCode::kUsage, "2 times");
  write({"/channel", "/z", "/y", "/x"});
  expectRead(channel, {4, 3, 2});
  write({"", "/z", "/y", "/x"});
  expectRead(channel, {4, 3, 2});
  expectRead(time, {4, 3, 2});
  write({"/energy", "/z", "/y", "/x"});
  expectRefused(file, ErrorCode::kUnsupported, "the axis 'energy' of (2, 3, 4, 5) has 2 entries");
}

// Known: ilastik writes the order of the axes; an axis of one entry behind three others is a channel.
TEST(IngestHdf5, ChannelsMayBeBehind) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({2, 12, 5}, VoxelType::u8, 537);  // channels, rows of 4 x 3, slices
  const fs::path file = files.directory() / "a.h5";
  {
    Hdf5File out(file);
    out.add("/tagged", volume, {.shape = {5, 3, 4, 2}, .chunk = {2, 2, 2, 2}});
    out.setText("/tagged", "axistags", R"({"axes": [{"key": "z"}, {"key": "y"}, {"key": "x"}, {"key": "c"}]})");
    out.setNumbers("/tagged", "element_size_um", {3, 2, 1});
    out.add("/single", volume, {.shape = {5, 6, 4, 1}});
    out.setNumbers("/single", "element_size_um", {3, 2, 1});
  }
  SourceOptions options;
  options.channel = "1";
  const auto source = openSource(part(file, "/tagged"), options);
  EXPECT_EQ(source->info().geometry.dims, (Extent3{4, 3, 5}));
  EXPECT_EQ(source->info().geometry.spacing(), glm::dvec3(1, 2, 3));
  const std::vector<std::byte> voxels = readWhole(*source);
  for (std::size_t i = 0; i < voxels.size(); ++i) ASSERT_EQ(voxels[i], volume.voxels[2 * i + 1]);
  ForeignVolume single = volume;
  single.dims = {4, 6, 5};
  expectReadsBack(single, part(file, "/single"), 538);
  const SourceInfo info = openSource(part(file, "/single"))->info();
  EXPECT_EQ(info.geometry.spacing(), glm::dvec3(1, 2, 3));
  EXPECT_TRUE(info.notes.empty()) << info.notes.front();
  const std::vector<ListedVolume> listed = volumesIn(file, {});
  ASSERT_EQ(listed.size(), 2u);
  EXPECT_EQ(listed[0].dims, (Extent3{4, 6, 5}));
  EXPECT_EQ(listed[1].dims, (Extent3{4, 3, 5}));
}

// Known: the attribute gives all three sizes; coordinates of one axis alone have another size and a begin.
TEST(IngestHdf5, ElementSizes_replaceCoordinates) {
  const ForeignFiles files;
  const fs::path file = files.directory() / "a.h5";
  {
    Hdf5File out(file);
    out.add("/v", randomVolume({4, 3, 5}, VoxelType::u8, 542));
    out.setNumbers("/v", "element_size_um", {4, 2, 1});
    out.addNumbers("/x", {100, 103, 106, 109});
    out.setScales("/v", {"", "", "/x"});
  }
  const auto source = openSource(file);
  EXPECT_EQ(at(*source, {0, 0, 0}), glm::dvec3(0));
  EXPECT_EQ(at(*source, {1, 1, 1}), glm::dvec3(1, 2, 4));
  EXPECT_EQ(source->info().notes,
            std::vector<std::string>{"element_size_um gives the size of a voxel; the coordinates /x are not used"});
}

// Known: the file is readable without names of axes.
TEST(IngestHdf5, DamagedAxisTags_areIgnoredWithANote) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({4, 3, 5}, VoxelType::u8, 541);
  const fs::path file = files.directory() / "a.h5";
  for (const char* const tags :
       {"z y x", "{}", R"({"axes": [{"key": "z"}, {"key": "y"}]})", R"({"axes": [{}, {"key": "y"}, {"key": "x"}]})",
        R"({"axes": [{"key": "x"}, {"key": "y"}, {"key": "x"}]})"}) {
    SCOPED_TRACE(tags);
    {
      Hdf5File out(file);
      out.add("/v", volume);
      out.setText("/v", "axistags", tags);
    }
    const auto source = openSource(file);
    EXPECT_TRUE(readWhole(*source) == volume.voxels);
    EXPECT_EQ(std::count(source->info().notes.begin(), source->info().notes.end(),
                         "the attribute axistags of /v does not name the 3 axes one by one and is ignored"),
              1);
  }
}

// Known: the library finds objects of other files by the path of a link.
TEST(IngestHdf5, GroupsOfOtherFilesAreSearched) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kDims, VoxelType::i16, 539);
  Hdf5File(files.directory() / "part.h5").add("/t00000/s00/0/cells", volume, {.chunk = kChunk, .deflate = 1});
  const fs::path whole = files.directory() / "whole.h5", loop = files.directory() / "loop.h5";
  {
    Hdf5File out(whole);
    out.addNumbers("/s00/resolutions", {1, 1, 1}, {1, 3});
    out.linkOutside("/t00000/s00", "part.h5", "/t00000/s00");
    out.linkOutside("/gone", "gone.h5", "/");
  }
  EXPECT_TRUE(readWhole(*openSource(whole)) == volume.voxels);
  // A file that leads back is walked once.
  {
    Hdf5File out(loop);
    out.add("/v", volume);
    out.linkOutside("/to", "back.h5", "/");
  }
  {
    Hdf5File out(files.directory() / "back.h5");
    out.linkOutside("/fro", "loop.h5", "/");
    out.linkOutside("/self", "back.h5", "/");
  }
  EXPECT_TRUE(readWhole(*openSource(loop)) == volume.voxels);
}

// Known: the test writes another file of more objects than are listed, to which a link in front of all others leads.
TEST(IngestHdf5, GroupsOfOtherFilesBeyondTheList_areFoundByTheirPlace) {
  const ForeignFiles files;
  const ForeignVolume fine = randomVolume({6, 5, 4}, VoxelType::i16, 543),
                      coarse = randomVolume({3, 5, 4}, VoxelType::i16, 544);
  {
    Hdf5File out(files.directory() / "many.h5");
    for (int i = 0; i < 10'000; ++i) out.addGroup("/" + std::to_string(i));
  }
  const auto write = [&](const fs::path& file, auto add) {
    Hdf5File out(file);
    out.linkOutside("/a", "many.h5", "/");
    add(out);
  };
  {
    Hdf5File out(files.directory() / "part.h5");
    out.add("/t00001/s00/0/cells", fine);
    out.add("/t00001/s00/1/cells", coarse);
    out.add("/level/TimePoint 0/Channel 0/Data", fine);
  }
  const fs::path bdv = files.directory() / "bdv.h5", imaris = files.directory() / "a.ims",
                 plain = files.directory() / "plain.h5";
  write(bdv, [](Hdf5File& out) {
    out.addNumbers("/s00/resolutions", {1, 1, 1, 2, 1, 1}, {2, 3});
    out.linkOutside("/t00000/s00", "part.h5", "/t00000/s00");
    out.linkOutside("/t00001/s00", "part.h5", "/t00001/s00");
  });
  SourceOptions options;
  options.time = 1;
  EXPECT_TRUE(readWhole(*openSource(bdv, options)) == fine.voxels);
  options.scale = 1;
  EXPECT_TRUE(readWhole(*openSource(bdv, options)) == coarse.voxels);
  EXPECT_TRUE(readWhole(*openSource(part(bdv, "/t00001/s00/1/cells"))) == coarse.voxels);
  options.scale = 2;
  expectRefused(bdv, ErrorCode::kUsage, "--scale: must be a number from 0 to 1", options);
  write(imaris, [](Hdf5File& out) { out.linkOutside("/DataSet/ResolutionLevel 0", "part.h5", "/level"); });
  EXPECT_TRUE(readWhole(*openSource(imaris)) == fine.voxels);
  // Which data set is the only one is unknown.
  write(plain, [&](Hdf5File& out) { out.add("/v", fine); });
  expectRefused(plain, ErrorCode::kUsage, "more objects than are listed");
  EXPECT_TRUE(readWhole(*openSource(part(plain, "/v"))) == fine.voxels);
  const std::vector<ListedVolume> listed = volumesIn(plain, {});
  ASSERT_EQ(listed.size(), 2u);
  EXPECT_NE(listed[1].refusal.find("more objects than are listed"), std::string::npos);
}

TEST(IngestHdf5, SoftLinksLeadToDataSets) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kDims, VoxelType::u16, 519);
  const fs::path file = files.directory() / "a.nxs";
  {
    Hdf5File out(file);
    out.add("/raw/counts", volume, {.chunk = kChunk, .deflate = 1});
    out.addGroup("/entry");
    out.link("/entry/data", "/raw/counts");
    out.link("/entry/nowhere", "/raw/none");
  }
  expectReadsBack(volume, file, 520);
  expectReadsBack(volume, part(file, "/entry/data"), 521);
  expectRefused(part(file, "/entry/nowhere"), ErrorCode::kNotFound, "no data set of this name");
}

// Known: more chunks than are listed, so that the library reads each chunk.
TEST(IngestHdf5, ManySmallChunksReadBack) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({160, 126, 1}, VoxelType::u8, 522);
  const fs::path file = files.directory() / "a.h5";
  Hdf5File(file).add("/v", volume, {.chunk = {1, 1, 1}});
  EXPECT_TRUE(readWhole(*openSource(part(file, "/v"))) == volume.voxels);
}

TEST(IngestHdf5, InfiniteFillValue_isKept) {
  const ForeignFiles files;
  const fs::path file = files.directory() / "a.h5";
  const ForeignVolume volume = randomVolume({4, 3, 2}, VoxelType::f32, 523);
  Hdf5File(file).add("/v", volume,
                     {.chunk = {2, 3, 4}, .fill = std::numeric_limits<double>::infinity(), .written = false});
  const std::vector<std::byte> voxels = readWhole(*openSource(file));
  for (std::size_t at = 0; at < voxels.size(); at += sizeof(float)) {
    float value;
    std::memcpy(&value, &voxels[at], sizeof value);
    EXPECT_EQ(value, std::numeric_limits<float>::infinity());
  }
}

// Known: the data set lies in the file with other objects behind.
TEST(IngestHdf5, ContiguousData_haveNoNoteOfBytesBehind) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kDims, VoxelType::u16, 524);
  const fs::path file = files.directory() / "a.h5";
  {
    Hdf5File out(file);
    out.add("/v", volume);
    out.addNumbers("/behind", std::vector<double>(1000, 1));
  }
  const auto source = openSource(file);
  EXPECT_TRUE(readWhole(*source) == volume.voxels);
  source->finish();
  for (const std::string& note : source->info().notes) EXPECT_EQ(note.find("behind"), std::string::npos) << note;
}

TEST(IngestHdf5, BigDataViewerWithADamagedXml_isAnError) {
  const ForeignFiles files;
  const fs::path file = files.directory() / "a.h5";
  {
    Hdf5File out(file);
    out.addNumbers("/s00/resolutions", {1, 1, 1}, {1, 3});
    out.add("/t00000/s00/0/cells", randomVolume({6, 5, 4}, VoxelType::i16, 525));
  }
  const auto refused = [&](const std::string& affine, const std::string& more, const std::string& text) {
    files.write(
        "a.xml",
        "<?xml version=\"1.0\"?>" + more +
            "<SpimData><ViewRegistrations><ViewRegistration timepoint=\"0\" setup=\"0\">\n<ViewTransform><affine>" +
            affine + "</affine></ViewTransform></ViewRegistration></ViewRegistrations></SpimData>");
    expectRefused(file, ErrorCode::kFormat, text);
  };
  refused("1 0 0 0 0 1 0 0 0 0 x 0", "", "line 2: affine must hold 12 numbers");
  refused("1 0 0 0 0 1 0 0 0 0 1", "", "affine must hold 12 numbers");
  refused("1 0 0 0 0 1 0 0 0 0 1 0", "<!DOCTYPE a>", "document type");
  refused("1 0 0 0 0 1 0 0 0 0 1 0</b>", "", "the XML is cut short or damaged");
  files.write("a.xml",
              "<SpimData><ViewRegistrations><ViewRegistration timepoint=\"0\" setup=\"0\"><ViewTransform><affine>2 0 0 "
              "0\n0 2 0 0\n0 0 2 0</affine></ViewTransform></ViewRegistration></ViewRegistrations></SpimData>");
  EXPECT_EQ(at(*openSource(file), {1, 1, 1}), glm::dvec3(2));
}

TEST(IngestHdf5, MincHasDirectionCosines) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({4, 3, 5}, VoxelType::f32, 521);
  const fs::path file = files.directory() / "a.mnc";
  const auto write = [&](const std::vector<double>& maxima) {
    Hdf5File out(file);
    out.add("/minc-2.0/image/0/image", volume);
    out.setText("/minc-2.0/image/0/image", "dimorder", "zspace,yspace,xspace");
    out.addNumbers("/minc-2.0/image/0/image-max", maxima);
    const std::vector<double> cosines[] = {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}};
    const char* const names[] = {"xspace", "yspace", "zspace"};
    for (int i = 0; i < 3; ++i) {
      const std::string path = std::string("/minc-2.0/dimensions/") + names[i];
      out.addNumbers(path, {0});
      out.setNumbers(path, "start", {10.0 * (i + 1)});
      out.setNumbers(path, "step", {1.0 + i});
      out.setNumbers(path, "direction_cosines", cosines[i]);
    }
  };
  write({9, 9, 9, 9, 9});
  const auto source = openSource(file);
  EXPECT_EQ(source->info().geometry.frame, PatientFrame::kRas);
  EXPECT_EQ(at(*source, {0, 0, 0}), glm::dvec3(-20, 10, 30));
  EXPECT_EQ(at(*source, {1, 1, 1}), glm::dvec3(-22, 11, 33));
  // Floats are values, whatever the largest one of each slice.
  write({9, 9, 8, 9, 9});
  EXPECT_TRUE(readWhole(*openSource(file)) == volume.voxels);
}

// Known: the range of a type's numbers stands for the range of each slice. Slopes are powers of two, so floats are
// exact.
TEST(IngestHdf5, SlicesOfMincAreScaledOneByOne) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({4, 3, 5}, VoxelType::u8, 523);
  const std::vector<double> slopes = {1, 2, 0.5, 4, 8}, least = {0, 1, -2, 3, 100};
  std::vector<double> most;
  for (std::size_t i = 0; i < least.size(); ++i) most.push_back(least[i] + 255 * slopes[i]);
  const fs::path file = files.directory() / "a.mnc";
  const auto write = [&](const char* order, const std::vector<double>& minima) {
    Hdf5File out(file);
    out.add("/minc-2.0/image/0/image", volume);
    out.setText("/minc-2.0/image/0/image", "dimorder", order);
    out.addNumbers("/minc-2.0/image/0/image-min", minima);
    out.addNumbers("/minc-2.0/image/0/image-max", most);
  };
  const auto expected = [&](int x, int y, int z, std::size_t slice) {
    const auto stored = std::to_integer<int>(volume.voxels[static_cast<std::size_t>(x + 4 * (y + 3 * z))]);
    return static_cast<float>(stored * slopes[slice] + least[slice]);
  };
  write("zspace,yspace,xspace", least);
  ForeignVolume floats{volume.dims, VoxelType::f32, std::vector<std::byte>(60 * sizeof(float))};
  for (int i = 0; i < 60; ++i) {
    const float value = expected(i % 4, i / 4 % 3, i / 12, static_cast<std::size_t>(i / 12));
    std::memcpy(&floats.voxels[static_cast<std::size_t>(i) * sizeof value], &value, sizeof value);
  }
  expectReadsBack(floats, file, 524);
  EXPECT_EQ(volumesIn(file, {}).at(0).type, VoxelType::f32);
  // Slices across x: the file's first axis is the volume's x, and its last one y.
  write("xspace,zspace,yspace", least);
  ForeignVolume turned{{5, 4, 3}, VoxelType::f32, std::vector<std::byte>(60 * sizeof(float))};
  for (int i = 0; i < 60; ++i) {
    const int x = i % 5, y = i / 5 % 4, z = i / 20;
    const float value = expected(y, z, x, static_cast<std::size_t>(x));
    std::memcpy(&turned.voxels[static_cast<std::size_t>(i) * sizeof value], &value, sizeof value);
  }
  expectReadsBack(turned, file, 525);
  write("zspace,yspace,xspace", {1, 2});
  expectRefused(file, ErrorCode::kUnsupported, "scaled slice by slice");
}

// Known: more slices than the worker lists numbers.
TEST(IngestHdf5, ScalesOfTooManySlicesOfMinc_areRefused) {
  const ForeignFiles files;
  constexpr std::int64_t kSlices = 4097;
  const fs::path file = files.directory() / "a.mnc";
  {
    Hdf5File out(file);
    out.add("/minc-2.0/image/0/image", randomVolume({2, 2, kSlices}, VoxelType::u8, 526));
    std::vector<double> maxima(kSlices, 1);
    maxima.back() = 2;
    out.addNumbers("/minc-2.0/image/0/image-max", maxima);
    out.addNumbers("/minc-2.0/image/0/image-min", std::vector<double>(kSlices, 0));
  }
  expectRefused(file, ErrorCode::kUnsupported, "scaled slice by slice");
}

// Known: the first bytes alone make the file one of HDF5.
TEST(IngestHdf5, FileOfItsMagicAlone_isDamagedHdf5) {
  const ForeignFiles files;
  expectRefused(files.write("d", "\x89HDF\r\n\x1a\n"), ErrorCode::kFormat, "HDF5");
}

// Known: the file holds the volume once, so a changed byte changes a voxel, a length or nothing.
TEST(IngestHdf5, CutsAndFlipsAreErrorsOrHarmless) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({6, 5, 4}, VoxelType::u16, 531);
  const fs::path file = files.directory() / "a.h5";
  Hdf5File(file).add("/v", volume, {.chunk = {2, 3, 4}, .shuffle = true, .fletcher32 = true, .deflate = 1});
  const std::string whole = bytesOf(file);
  std::mt19937_64 random(532);
  int refused = 0;
  for (int i = 0; i < 60; ++i) {
    const bool cut = i % 2 == 0;
    std::string damaged = whole;
    if (cut)
      damaged.resize(random() % whole.size());
    else
      for (int flips = 0; flips < 4; ++flips)
        damaged[random() % damaged.size()] ^= static_cast<char>(1u << (random() % 8));
    files.write("a.h5", damaged);
    try {
      const std::vector<std::byte> voxels = readWhole(*openSource(file));
      EXPECT_TRUE(!cut || voxels == volume.voxels) << damaged.size() << " of " << whole.size() << " bytes";
    } catch (const Error& error) {
      ++refused;
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
  EXPECT_GT(refused, 30);
}

}  // namespace
}  // namespace kiln::test
