// Folders of grey slices of JPEG 2000. Known because opj_compress writes the slices without loss.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "ingest/open_source.h"
#include "ingest/volume_list.h"
#include "support/files/picture_files.h"
#include "support/system/sanitized.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class IngestJpeg2000 : public ::testing::Test {
 protected:
  IngestJpeg2000() { fs::create_directory(folder_); }
  void put(const std::string& name, const std::string& bytes) const { files_.write("scan/" + name, bytes); }
  void putSlices(const ForeignVolume& volume, const std::string& ending, const Jpeg2000Layout& layout = {}) const {
    for (std::int64_t z = 0; z < volume.dims.z; ++z)
      put(fmt::format("s{}{}", 8 + z, ending), jpeg2000Slice(volume, z, layout));
  }
  void refused(const std::string& bytes, ErrorCode code, const std::string& part) const {
    put("a.jp2", bytes);
    expectRefused(folder_, code, part);
    fs::remove(folder_ / "a.jp2");
  }
  ForeignFiles files_;
  fs::path folder_ = files_.directory() / "scan";
};

// Returns values of up to `bits` bits.
ForeignVolume narrowVolume(int bits) {
  ForeignVolume out = randomVolume({21, 19, 3}, VoxelType::u16, 701);
  for (std::size_t i = 1; i < out.voxels.size(); i += 2) out.voxels[i] &= std::byte((1 << (bits - 8)) - 1);
  return out;
}

TEST_F(IngestJpeg2000, CodestreamsAndBoxesReadBack) {
  std::uint64_t seed = 702;
  for (const bool boxes : {false, true}) {
    for (const VoxelType type : {VoxelType::u8, VoxelType::i8, VoxelType::u16, VoxelType::i16}) {
      SCOPED_TRACE(testing::Message() << nameOf(type) << " in boxes " << boxes);
      const ForeignVolume volume = randomVolume({21, 19, 3}, type, seed);
      putSlices(volume, boxes ? ".jp2" : ".j2k", {.boxes = boxes});
      expectReadsBack(volume, folder_, ++seed);
      EXPECT_EQ(openSource(folder_)->info().format, "JPEG 2000, 3 slices");
      fs::remove_all(folder_), fs::create_directory(folder_);
    }
  }
}

TEST_F(IngestJpeg2000, ValuesOfTwelveBitsInTilesReadBack) {
  const ForeignVolume volume = narrowVolume(12);
  putSlices(volume, ".j2k", {.bits = 12, .options = "-t 8,8 -n 2"});
  expectReadsBack(volume, folder_, 711);
  ASSERT_EQ(volumesIn(folder_, {}).size(), 1u);
  EXPECT_EQ(volumesIn(folder_, {})[0].dims, volume.dims);
}

TEST_F(IngestJpeg2000, SeveralThreadsReadAtOnce) {
  const ForeignVolume volume = randomVolume({40, 30, 6}, VoxelType::u16, 721);
  putSlices(volume, ".jp2", {.boxes = true});
  const auto source = openSource(folder_);
  source->keepDecoded(5000);
  expectThreadsReadBack(volume, *source);
  EXPECT_GE(source->decodeBytes(), 2 * 40 * 30 * 4u);
}

TEST_F(IngestJpeg2000, OtherPicturesAreRefusedByName) {
  const ForeignVolume volume = randomVolume({9, 8, 2}, VoxelType::u8, 731);
  const std::string whole = jpeg2000Slice(volume, 0, {.boxes = true});
  refused(jpeg2000Slice(volume, 0, {.components = 3}), ErrorCode::kUnsupported, "holds 3 components a pixel");
  refused(replaced(whole, "colr", "pclr"), ErrorCode::kUnsupported, "holds numbers of a palette");
  refused(whole.substr(0, whole.find("jp2c") - 4), ErrorCode::kFormat, "has no codestream");
  refused(whole.substr(0, 20), ErrorCode::kFormat, "a box of 20 bytes lies in 8");
  std::string wide = whole;
  wide[whole.find("\xff\x4f\xff\x51") + 42] = 19;
  refused(wide, ErrorCode::kUnsupported, "holds values of 20 bits");
  put("s0.jp2", whole);
  put("s1.jp2", jpeg2000Slice(randomVolume({8, 9, 1}, VoxelType::u8, 732), 0));
  expectRefused(folder_, ErrorCode::kFormat, "slice 1 is 8 x 9 of u8");
  fs::remove(folder_ / "s1.jp2");
  put("s1.png", pngSlice(volume, 1));
  expectRefused(folder_, ErrorCode::kUnsupported, "holds PNG files ('s1.png') and JPEG 2000 files ('s0.jp2')");
  expectRefused(folder_ / "s0.jp2", ErrorCode::kUnsupported, "a JPEG 2000 file, which is not read");
}

// Columns beyond the only tile: OpenJPEG fills them with grey.
TEST_F(IngestJpeg2000, ASizeThatLies_isAnErrorOfTheSlice) {
  const ForeignVolume volume = randomVolume({16, 12, 1}, VoxelType::u16, 741);
  std::string whole = jpeg2000Slice(volume, 0);
  whole[8 + 3] = 17;
  put("s0.j2k", whole);
  try {
    readWhole(*openSource(folder_));
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFormat);
    EXPECT_NE(std::string(error.what()).find("s0.j2k: "), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("tile 1 of 2 has no data"), std::string::npos) << error.what();
  }
}

TEST_F(IngestJpeg2000, EveryCutIsNoticedAndFlipsAreHarmless) {
  const ForeignVolume volume = randomVolume({12, 9, 2}, VoxelType::u16, 751);
  for (const bool boxes : {false, true}) {
    putSlices(volume, ".jp2", {.boxes = boxes});
    const std::string slice = jpeg2000Slice(volume, 1, {.boxes = boxes});
    expectNoCutGoesUnnoticed(volume, files_, "scan/s9.jp2", slice, folder_);
    expectBitFlipsAreHarmless(files_, "scan/s9.jp2", slice, slice.size(), folder_, 752, {}, casesOf(150, 50));
    fs::remove_all(folder_), fs::create_directory(folder_);
  }
}

}  // namespace
}  // namespace kiln::test
