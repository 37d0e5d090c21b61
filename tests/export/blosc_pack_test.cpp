// Frames of Blosc read back by Kiln's own reader of frames, which is tested with frames of other writers.
#include "export/zarr/blosc_pack.h"

#include <gtest/gtest.h>

#include "ingest/codec/blosc_frame.h"
#include "support/files/foreign_files.h"

namespace kiln::test {
namespace {

std::vector<std::byte> unpacked(const std::vector<std::byte>& frame, std::size_t bytes) {
  std::vector<std::byte> out(bytes);
  std::size_t written = 0;
  EXPECT_EQ(unpackBlosc(frame, out, written), "");
  EXPECT_EQ(written, bytes);
  return out;
}

TEST(BloscPack, NumbersOfEachSizeComeBack) {
  for (const VoxelType type : kAllTypes) {
    for (const std::int64_t count : {1, 7, 4096}) {
      const std::vector<std::byte> noise = randomVolume({count, 1, 1}, type, 3).voxels,
                                   same(noise.size(), std::byte{5});
      for (const std::vector<std::byte>& numbers : {noise, same}) {
        const std::vector<std::byte> frame = packBlosc(numbers, sizeOf(type));
        EXPECT_LE(frame.size(), packedBloscBytes(numbers.size()));
        EXPECT_TRUE(unpacked(frame, numbers.size()) == numbers) << nameOf(type) << " " << count;
      }
    }
    const std::vector<std::byte> same(1 << 15, std::byte{5});
    EXPECT_LT(packBlosc(same, sizeOf(type)).size(), same.size() / 20);
  }
}

}  // namespace
}  // namespace kiln::test
