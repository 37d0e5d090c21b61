// Known because Blosc itself makes the frames, and because unpacking must return the packed bytes.
#include <blosc.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <vector>

#include "store/codec/leaf_frame.h"

namespace kiln {
namespace {

struct BloscSetting {
  int split = BLOSC_NEVER_SPLIT, shuffle = BLOSC_SHUFFLE;
  std::size_t type_bytes = kBloscTypeBytes;
  const char* codec = BLOSC_LZ4_COMPNAME;
  std::size_t block_bytes = 0;  // 0: all bytes
};

template <class Stored>
std::vector<std::byte> leafFrameOf(const std::vector<Stored>& values, const BloscSetting& setting = {}) {
  const std::size_t bytes = values.size() * sizeof(Stored);
  std::vector<std::byte> out(bytes + BLOSC_MAX_OVERHEAD);
  blosc_set_splitmode(setting.split);
  const int length =
      blosc_compress_ctx(9, setting.shuffle, setting.type_bytes, bytes, values.data(), out.data(), out.size(),
                         setting.codec, setting.block_bytes > 0 ? setting.block_bytes : bytes, 1);
  blosc_set_splitmode(BLOSC_NEVER_SPLIT);
  EXPECT_GT(length, 0);
  out.resize(static_cast<std::size_t>(length));
  return out;
}

// Returns values like real voxels: noise in the last bits on a constant.
template <class Stored>
std::vector<Stored> leafValuesOf(std::size_t count, double first, double range) {
  std::mt19937 random(static_cast<unsigned>(count));
  std::uniform_real_distribution<double> noise(first, first + range);
  std::vector<Stored> out(count);
  for (Stored& value : out) value = static_cast<Stored>(noise(random));
  return out;
}

template <class Stored, class T>
void expectUnpackedLeaf(const std::vector<Stored>& values) {
  const std::vector<std::byte> frame = leafFrameOf(values);
  ASSERT_TRUE(isLeafFrame(frame, values.size() * sizeof(Stored))) << values.size();
  using Unpacked = UnpackedFor<Stored, T>;
  std::vector<Unpacked> unpacked(values.size());
  ASSERT_TRUE(unpackLeaf<Stored>(frame, values.size(), unpacked.data()));
  for (std::size_t i = 0; i < values.size(); ++i) ASSERT_EQ(unpacked[i], static_cast<Unpacked>(values[i])) << i;
}

TEST(LeafFrame, HoldsWhatWentIn) {
  for (const std::size_t count : {512, 511, 384, 216, 64, 36, 1}) {
    SCOPED_TRACE(count);
    expectUnpackedLeaf<std::int32_t, std::uint8_t>(leafValuesOf<std::int32_t>(count, 90, 40));
    expectUnpackedLeaf<std::int32_t, std::int8_t>(leafValuesOf<std::int32_t>(count, -20, 40));
    expectUnpackedLeaf<std::int32_t, std::uint16_t>(leafValuesOf<std::int32_t>(count, 65000, 500));
    expectUnpackedLeaf<std::int32_t, std::int16_t>(leafValuesOf<std::int32_t>(count, -300, 600));
    expectUnpackedLeaf<std::int32_t, std::int32_t>(leafValuesOf<std::int32_t>(count, -100000, 200000));
    expectUnpackedLeaf<std::int64_t, std::uint32_t>(leafValuesOf<std::int64_t>(count, 4e9, 2e8));
    expectUnpackedLeaf<std::uint16_t, std::uint16_t>(leafValuesOf<std::uint16_t>(count, 3000, 800));
    expectUnpackedLeaf<float, float>(leafValuesOf<float>(count, -1, 2));
    expectUnpackedLeaf<double, double>(leafValuesOf<double>(count, -1, 2));
    expectUnpackedLeaf<std::int32_t, std::int16_t>(std::vector<std::int32_t>(count, -1024));
    expectUnpackedLeaf<std::int32_t, std::uint8_t>(std::vector<std::int32_t>(count, 200));
  }
}

// Frames of writers that split blocks, use other sizes of numbers, or leave the bytes in their order.
TEST(LeafFrame, OfAnyLayoutHoldsWhatWentIn) {
  const auto values = leafValuesOf<std::int32_t>(512, 0, 1000);
  const std::size_t bytes = values.size() * sizeof values[0];
  for (const BloscSetting& setting :
       {BloscSetting{.split = BLOSC_ALWAYS_SPLIT}, BloscSetting{.shuffle = BLOSC_NOSHUFFLE},
        BloscSetting{.type_bytes = 2}, BloscSetting{.type_bytes = 8}, BloscSetting{.type_bytes = 3},
        BloscSetting{.block_bytes = 640}, BloscSetting{.split = BLOSC_ALWAYS_SPLIT, .block_bytes = 640}}) {
    const std::vector<std::byte> frame = leafFrameOf(values, setting);
    ASSERT_TRUE(isLeafFrame(frame, bytes));
    EXPECT_FALSE(isPlainFrame(frame, bytes));
    std::vector<std::int32_t> unpacked(values.size());
    ASSERT_TRUE(unpackLeaf<std::int32_t>(frame, values.size(), unpacked.data()));
    EXPECT_EQ(unpacked, values);
    std::vector<std::uint16_t> low(values.size());
    ASSERT_TRUE(unpackLeaf<std::int32_t>(frame, values.size(), low.data()));
    EXPECT_TRUE(std::equal(low.begin(), low.end(), values.begin()));
  }
}

TEST(LeafFrame, IsNoOtherFrame) {
  const auto values = leafValuesOf<std::int32_t>(512, 0, 1000);
  const std::size_t bytes = values.size() * sizeof values[0];
  EXPECT_TRUE(isLeafFrame(leafFrameOf(values), bytes));
  EXPECT_TRUE(isPlainFrame(leafFrameOf(values), bytes));
  EXPECT_FALSE(isLeafFrame(leafFrameOf(values), bytes - 4));
  EXPECT_FALSE(isLeafFrame(leafFrameOf(values, {.shuffle = BLOSC_BITSHUFFLE}), bytes));
  EXPECT_FALSE(isLeafFrame(leafFrameOf(values, {.codec = BLOSC_BLOSCLZ_COMPNAME}), bytes));
  std::vector<std::byte> frame = leafFrameOf(values);
  frame.pop_back();
  EXPECT_FALSE(isLeafFrame(frame, bytes));
  for (std::size_t length = 0; length < 24; ++length)
    EXPECT_FALSE(isLeafFrame(std::span<const std::byte>(frame).first(length), bytes));
}

// Values of every length, from those that LZ4 packs well to those that it does not pack.
TEST(LeafFrame, OfTheWriterIsBloscs) {
  std::mt19937 random(3);
  for (std::size_t count = 1; count <= 2048; count += count < 80 ? 1 : 29) {
    for (const std::uint32_t range : {1u, 40u, 3000u, 65535u}) {
      std::vector<std::uint16_t> values(count);
      for (std::uint16_t& value : values) value = static_cast<std::uint16_t>(random() % range);
      std::vector<std::byte> frame(2 * count + kFrameOverhead_bytes);
      frame.resize(packLeaf(values.data(), 2 * count, frame.data()));
      ASSERT_EQ(frame, leafFrameOf(values)) << count << " below " << range;
    }
  }
}

// Blosc packs redundant bytes and stores random bytes unpacked.
TEST(LeafFrame, IsPackedOrKept) {
  EXPECT_EQ(keptValues(leafFrameOf(leafValuesOf<std::int32_t>(512, 0, 1000))), nullptr);
  std::vector<std::int32_t> noise(512);
  std::mt19937 random(1);
  for (std::int32_t& value : noise) value = static_cast<std::int32_t>(random());
  const std::vector<std::byte> kept = leafFrameOf(noise);
  ASSERT_TRUE(isLeafFrame(kept, 2048));
  EXPECT_EQ(std::memcmp(keptValues(kept), noise.data(), 2048), 0);
}

// A damaged frame is either refused or unpacks to other bytes, without writing beyond the buffer.
template <class Unpack>
void expectDamageInItsPlace(const std::vector<std::byte>& whole, std::size_t bytes, std::size_t from, Unpack&& unpack) {
  std::mt19937 random(2);
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::byte> frame = whole;
    for (int n = 0; n < 4; ++n) frame[from + random() % (frame.size() - from)] = static_cast<std::byte>(random());
    ASSERT_TRUE(isLeafFrame(frame, bytes));
    std::vector<std::uint8_t> out(bytes + 64, 0xa5);
    refused += unpack(frame, i, out.data()) ? 0 : 1;
    ASSERT_TRUE(std::all_of(out.begin() + static_cast<std::ptrdiff_t>(bytes), out.end(),
                            [](std::uint8_t byte) { return byte == 0xa5; }));
  }
  EXPECT_GT(refused, 0);
  EXPECT_LT(refused, 2000);
}

TEST(LeafFrame, DamageStaysInItsPlace) {
  const auto values = leafValuesOf<std::int32_t>(512, 0, 300);
  const std::size_t bytes = values.size() * sizeof values[0];
  expectDamageInItsPlace(leafFrameOf(values), bytes, 24, [&](const auto& frame, int i, std::uint8_t* out) {
    return unpackPlanes(frame, bytes, i % 2 == 0 ? bytes : bytes / 4, out);
  });
  constexpr std::size_t kBehindHead = 16;
  for (const BloscSetting& setting : {BloscSetting{}, BloscSetting{.split = BLOSC_ALWAYS_SPLIT, .block_bytes = 640}})
    expectDamageInItsPlace(leafFrameOf(values, setting), bytes, kBehindHead,
                           [&](const auto& frame, int, std::uint8_t* out) {
                             return unpackBlocks(frame, bytes, reinterpret_cast<std::byte*>(out));
                           });
}

}  // namespace
}  // namespace kiln
