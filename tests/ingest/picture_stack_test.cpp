// Folders of grey PNG and JPEG slices. Known because the test puts PNG files together chunk by chunk. JPEG of quality
// 100 keeps blocks of 8 x 8 equal pixels exactly.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "ingest/open_source.h"
#include "support/files/picture_files.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class IngestPictures : public ::testing::Test {
 protected:
  IngestPictures() { fs::create_directory(folder_); }
  void put(const std::string& name, const std::string& bytes) const { files_.write("scan/" + name, bytes); }
  void putSlices(const ForeignVolume& volume) const {
    for (std::int64_t z = 0; z < volume.dims.z; ++z) put("s" + std::to_string(8 + z) + ".png", pngSlice(volume, z));
  }
  ForeignFiles files_;
  fs::path folder_ = files_.directory() / "scan";
};

TEST_F(IngestPictures, PngOfEightAndSixteenBitsReadsBack) {
  for (const VoxelType type : {VoxelType::u8, VoxelType::u16}) {
    const ForeignVolume volume = randomVolume({21, 19, 4}, type, 601);
    putSlices(volume);
    put("notes.txt", "of the scanner");
    expectReadsBack(volume, folder_, 602);
    const auto source = openSource(folder_);
    EXPECT_EQ(source->info().format, "PNG, 4 slices");
    ASSERT_EQ(source->info().notes.size(), 2u);
    EXPECT_NE(source->info().notes[1].find("no size of a voxel"), std::string::npos);
    SourceOptions options;
    options.spacing = glm::dvec3(1, 2, 3);
    EXPECT_EQ(openSource(folder_, options)->info().geometry.worldOf({1, 1, 1}), glm::dvec3(1, 2, 3));
  }
}

// Known: 1, 2 and 4 bits are packed from the left, and are values as they stand.
TEST_F(IngestPictures, PackedBitsAreValues) {
  put("s0.png", pngFile(3, 2, 4, 0, "\x1f\x20\x3e\x40"));
  EXPECT_TRUE(readWhole(*openSource(folder_)) == (std::vector<std::byte>{std::byte{1}, std::byte{15}, std::byte{2},
                                                                         std::byte{3}, std::byte{14}, std::byte{4}}));
}

TEST_F(IngestPictures, SeveralThreadsReadAtOnce) {
  const ForeignVolume volume = randomVolume({40, 30, 6}, VoxelType::u16, 611);
  putSlices(volume);
  const auto source = openSource(folder_);
  source->keepDecoded(5000);
  expectThreadsReadBack(volume, *source);
}

TEST_F(IngestPictures, FlatBlocksOfJpegReadBack) {
  ForeignVolume volume = {{24, 16, 3}, VoxelType::u8, {}};
  for (int z = 0; z < 3; ++z) {
    std::string pixels;
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 24; ++x) pixels += static_cast<char>(17 * (x / 8) + 90 * (y / 8) + 5 * z);
    put(fmt::format("s{}.jpg", z), jpegFile(24, 16, 1, pixels));
    for (const char pixel : pixels) volume.voxels.push_back(static_cast<std::byte>(pixel));
  }
  expectReadsBack(volume, folder_, 621);
  EXPECT_EQ(openSource(folder_)->info().format, "JPEG, 3 slices");
}

// Known: the header of a JPEG file is at its front, or behind segments of up to 64 KiB each.
TEST_F(IngestPictures, HeaderOfJpegIsRead_NotTheFile) {
  const std::string jpeg = jpegFile(8, 8, 1, std::string(64, 'f'));
  const std::string segment = "\xff\xe2\xff\xfe" + std::string(0xfffc, 'x');
  put("s0.jpg", jpeg.substr(0, 2) + segment + segment + jpeg.substr(2));
  EXPECT_TRUE(readWhole(*openSource(folder_)) == std::vector<std::byte>(64, std::byte{'f'}));
  put("s0.jpg", jpeg);
  fs::resize_file(folder_ / "s0.jpg", std::uintmax_t{1} << 40);
  EXPECT_EQ(openSource(folder_)->info().geometry.dims, (Extent3{8, 8, 1}));
}

// Known: a picture is decoded from the whole file, and progressive JPEG holds two bytes of coefficients a pixel.
TEST_F(IngestPictures, DecodingChargesTheFile) {
  const std::uint64_t extra = 3 << 20;
  put("s0.png", pngFile(4, 4, 8, 0, std::string(16, 'x'), pngChunk("prIv", std::string(extra, 'p'))));
  EXPECT_GE(openSource(folder_)->decodeBytes(), extra + 16);
  const auto source = openSource(folder_);
  put("s0.png", pngFile(4, 4, 8, 0, std::string(16, 'x'), pngChunk("prIv", std::string(2 * extra, 'p'))));
  EXPECT_THROW(readWhole(*source), Error);
  fs::remove(folder_ / "s0.png");
  const std::string jpeg = jpegFile(24, 16, 1, std::string(24 * 16, 'f'));
  put("s0.jpg", jpeg);
  EXPECT_GE(openSource(folder_)->decodeBytes(), jpeg.size() + 3 * 24 * 16);
}

TEST_F(IngestPictures, ChannelOrTimeOfOneStack_IsRefused) {
  putSlices(randomVolume({5, 4, 3}, VoxelType::u8, 651));
  SourceOptions options;
  options.channel = "1";
  expectRefused(folder_, ErrorCode::kUsage, "--channel: '1' is none of the channels 0 to 0", options);
  options = {}, options.time = 2;
  expectRefused(folder_, ErrorCode::kUsage, "--time: expected a number from 0 to 0 (found 2)", options);
  options.time = 0, options.channel = "0";
  EXPECT_EQ(openSource(folder_, options)->info().format, "PNG, 3 slices");
}

TEST_F(IngestPictures, ChannelOfTheNamesIsChosen) {
  const ForeignVolume volume = randomVolume({5, 4, 6}, VoxelType::u8, 631);
  for (std::int64_t i = 0; i < 6; ++i) put(fmt::format("z{}_c{}.png", i / 2, i % 2), pngSlice(volume, i));
  expectRefused(folder_, ErrorCode::kUsage, "choose one by its number with --channel");
  SourceOptions options;
  options.channel = "1";
  expectReadsBack(
      volume.slices({1, 3, 5}), [&] { return openSource(folder_, options); }, 632);
}

TEST_F(IngestPictures, OtherPicturesAreRefusedByName) {
  const std::string pixels(64, 'x');
  const auto refused = [&](const std::string& name, const std::string& bytes, ErrorCode code, const std::string& part) {
    put(name, bytes);
    expectRefused(folder_, code, part);
    fs::remove(folder_ / name);
  };
  refused("a.png", pngFile(4, 4, 8, 2, pixels.substr(0, 48)), ErrorCode::kUnsupported, "RGB colours");
  refused("a.png", pngFile(4, 4, 8, 3, pixels.substr(0, 16)), ErrorCode::kUnsupported, "palette");
  refused("a.png", pngFile(4, 4, 8, 4, pixels.substr(0, 32)), ErrorCode::kUnsupported, "grey and alpha");
  refused("a.png", pngFile(2147483647, 1, 8, 0, pixels), ErrorCode::kFormat, "can hold");
  refused("a.png", pngFile(4, 4, 7, 0, pixels.substr(0, 16)), ErrorCode::kFormat, "libpng");
  refused("a.jpg", jpegFile(4, 4, 3, pixels), ErrorCode::kUnsupported, "holds 3 colours a pixel");
  put("s0.png", pngFile(4, 4, 8, 0, pixels.substr(0, 16)));
  refused("s1.png", pngFile(8, 2, 8, 0, pixels.substr(0, 16)), ErrorCode::kFormat, "slice 1 is 8 x 2 of u8");
  refused("s1.png", "", ErrorCode::kFormat, "is no PNG file: empty or damaged");
  refused("s1.jpg", jpegFile(4, 4, 1, pixels), ErrorCode::kUnsupported, "holds PNG files ('s0.png') and JPEG files");
}

TEST_F(IngestPictures, EveryCutIsNoticedAndFlipsAreHarmless) {
  const ForeignVolume volume = randomVolume({5, 4, 2}, VoxelType::u16, 641);
  putSlices(volume);
  const std::string png = pngSlice(volume, 1);
  expectNoCutGoesUnnoticed(volume, files_, "scan/s9.png", png, folder_);
  expectBitFlipsAreHarmless(files_, "scan/s9.png", png, png.size(), folder_, 642);
  fs::remove_all(folder_), fs::create_directory(folder_);
  const std::string flat(64, 'f'), jpeg = jpegFile(8, 8, 1, flat);
  put("s0.jpg", jpeg);
  ForeignVolume pair = {{8, 8, 2}, VoxelType::u8, std::vector<std::byte>(128, std::byte{'f'})};
  expectNoCutGoesUnnoticed(pair, files_, "scan/s1.jpg", jpeg, folder_);
  expectBitFlipsAreHarmless(files_, "scan/s1.jpg", jpeg, jpeg.size(), folder_, 643);
}

}  // namespace
}  // namespace kiln::test
