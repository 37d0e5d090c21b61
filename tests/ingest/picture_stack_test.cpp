// Folders of grey PNG and JPEG slices. Known because the test puts PNG files together chunk by chunk, and because JPEG
// of quality 100 keeps blocks of 8 x 8 equal pixels exactly.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdio>
#include <filesystem>

// jpeglib.h needs stdio.h in front.
#include <jpeglib.h>

#include "ingest/open_source.h"
#include "support/volumes/foreign_files.h"
#include "support/volumes/header_writer.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

std::string pngChunk(const std::string& name, const std::string& data) {
  std::string out(4, '\0');
  putNumber(out, 0, static_cast<std::uint32_t>(data.size()), true);
  out += name + data;
  std::string check(4, '\0');
  const std::string checked = name + data;
  putNumber(check, 0,
            static_cast<std::uint32_t>(
                crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size()))),
            true);
  return out + check;
}

// `rows` are packed rows of pixels, big-endian, without filter bytes.
std::string pngFile(int width, int height, int depth, int colour, const std::string& rows) {
  std::string header(13, '\0');
  putNumber(header, 0, width, true), putNumber(header, 4, height, true);
  header[8] = static_cast<char>(depth), header[9] = static_cast<char>(colour);
  std::string filtered;
  const std::size_t row = rows.size() / static_cast<std::size_t>(height);
  for (std::size_t at = 0; at < rows.size(); at += row) filtered += '\0' + rows.substr(at, row);
  return "\x89PNG\r\n\x1a\n" + pngChunk("IHDR", header) + pngChunk("IDAT", zlibbed(filtered)) + pngChunk("IEND", "");
}

std::string pngSlice(const ForeignVolume& volume, std::int64_t z) {
  const ForeignVolume slice = {
      {volume.dims.x, volume.dims.y, 1}, volume.type, volume.box({{0, 0, z}, {volume.dims.x, volume.dims.y, z + 1}})};
  return pngFile(static_cast<int>(volume.dims.x), static_cast<int>(volume.dims.y),
                 static_cast<int>(8 * sizeOf(volume.type)), 0, slice.stored(true));
}

std::string jpegFile(int width, int height, int components, const std::string& pixels) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors;
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* out = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &out, &size);
  jpeg.image_width = static_cast<JDIMENSION>(width), jpeg.image_height = static_cast<JDIMENSION>(height);
  jpeg.input_components = components;
  jpeg.in_color_space = components == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 100, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  for (int y = 0; y < height; ++y) {
    auto* row = reinterpret_cast<unsigned char*>(const_cast<char*>(pixels.data())) + y * width * components;
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  std::string bytes(reinterpret_cast<const char*>(out), size);
  jpeg_destroy_compress(&jpeg);
  std::free(out);
  return bytes;
}

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

TEST_F(IngestPictures, ChannelOfTheNamesIsChosen) {
  const ForeignVolume volume = randomVolume({5, 4, 6}, VoxelType::u8, 631);
  for (std::int64_t i = 0; i < 6; ++i) put(fmt::format("z{}_c{}.png", i / 2, i % 2), pngSlice(volume, i));
  expectRefused(folder_, ErrorCode::kUsage, "choose one by its number with --channel");
  SourceOptions options;
  options.channel = "1";
  ForeignVolume one = {{5, 4, 3}, VoxelType::u8, {}};
  for (const std::int64_t i : {1, 3, 5}) {
    const auto slice = volume.box({{0, 0, i}, {5, 4, i + 1}});
    one.voxels.insert(one.voxels.end(), slice.begin(), slice.end());
  }
  expectReadsBack(
      one, [&] { return openSource(folder_, options); }, 632);
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
