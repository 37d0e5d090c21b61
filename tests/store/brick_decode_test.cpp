// Decoding of input that the current writer does not produce: frames of earlier writers, another brick's leaves, and
// damaged bytes that the checksum did not catch.
#include <blosc.h>
#include <gtest/gtest.h>
#include <openvdb/version.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/file/file.h"
#include "base/memory/memory.h"
#include "grid/vdb_lengths.h"
#include "store/codec/brick_codec.h"
#include "store/codec/brick_file.h"
#include "store/ranges/minmax_octree.h"
#include "support/files/foreign_files.h"
#include "support/files/vdb_files.h"
#include "support/system/sanitized.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr std::int64_t kBrickEdge = 32;

// A brick at the corner of the volume, cut off on one side, with neighbours on the others.
BrickDesc brickFrame(VoxelType type) {
  BrickDesc out;
  out.key = {0, {1, 0, 1}};
  out.type = type;
  out.brick_size = kBrickEdge;
  out.apron = 6;
  out.geometry.dims = {53, 45, 96};
  return out;
}

// Slopes, noise and a constant part. The values need all bytes of the type, and some are not representable as half.
template <class T>
T brickValue(int number) {
  if constexpr (std::is_floating_point_v<T>)
    return static_cast<T>(number - 60) / T{7};
  else if constexpr (sizeof(T) == 1)
    return static_cast<T>(number - (std::is_signed_v<T> ? 60 : 0));
  else
    return static_cast<T>((std::is_signed_v<T> ? static_cast<T>(-300) : std::numeric_limits<T>::max() - T{200}) +
                          number);
}

std::vector<std::byte> brickVoxels(const BrickDesc& frame) {
  const VoxelBox box = frame.stored();
  std::vector<std::byte> out(static_cast<std::size_t>(box.extent().count()) * sizeOf(frame.type));
  std::mt19937 random(5);
  withVoxelType(frame.type, [&]<class T>(std::type_identity<T>) {
    T* to = reinterpret_cast<T*>(out.data());
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
        for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
          const bool even = x < 40;
          *to++ = brickValue<T>(even ? 7 : static_cast<int>(x + y + z + static_cast<int>(random() % 9)) % 120);
        }
      }
    }
  });
  return out;
}

std::vector<std::byte> encodedBrick(const BrickDesc& frame, const std::vector<std::byte>& voxels) {
  return encodeBrick(
      frame, voxels,
      cellRanges(voxels, frame.type, frame.stored(), frame.core(), static_cast<int>(frame.brick_size / kCellSize)));
}

// Compares all voxels of the block; beyond the volume the block repeats the last voxels.
void expectBrickVoxels(const BrickBlock& block, const BrickDesc& frame, const std::vector<std::byte>& voxels) {
  const VoxelBox box = frame.stored(), all = dilated(frame.core(), frame.apron);
  const Extent3 n = box.extent();
  const std::size_t bytes = sizeOf(frame.type);
  const auto nearest = [&](std::int64_t v, int axis) {
    return std::clamp(v, box.lo[axis], box.hi[axis] - 1) - box.lo[axis];
  };
  for (std::int64_t z = all.lo.z; z < all.hi.z; ++z) {
    for (std::int64_t y = all.lo.y; y < all.hi.y; ++y) {
      for (std::int64_t x = all.lo.x; x < all.hi.x; ++x) {
        const auto from = static_cast<std::size_t>((nearest(z, 2) * n.y + nearest(y, 1)) * n.x + nearest(x, 0)) * bytes;
        const auto at = static_cast<std::size_t>(block.offsetOf({x, y, z})) * bytes;
        ASSERT_EQ(std::memcmp(block.voxels.data() + at, voxels.data() + from, bytes), 0) << x << ' ' << y << ' ' << z;
      }
    }
  }
}

// Values representable as half are stored as half.
TEST(BrickDecode, GivesBackHalves) {
  for (const VoxelType type : {VoxelType::f32, VoxelType::f64}) {
    const BrickDesc frame = brickFrame(type);
    std::vector<std::byte> voxels = brickVoxels(frame);
    withVoxelType(type, [&]<class T>(std::type_identity<T>) {
      T* const values = reinterpret_cast<T*>(voxels.data());
      std::transform(values, values + voxels.size() / sizeof(T), values, [](T v) { return std::round(8 * v) / 4; });
    });
    const std::vector<std::byte> file = encodedBrick(frame, voxels);
    EXPECT_LT(file.size(), encodedBrick(frame, brickVoxels(frame)).size());
    expectBrickVoxels(decodeBrick(frame, file, "b.vdb"), frame, voxels);
  }
}

TEST(BrickDecode, GivesBackWhatWasEncoded) {
  for (const VoxelType type : kAllTypes) {
    SCOPED_TRACE(nameOf(type));
    const BrickDesc frame = brickFrame(type);
    const std::vector<std::byte> voxels = brickVoxels(frame);
    expectBrickVoxels(decodeBrick(frame, encodedBrick(frame, voxels), "b.vdb"), frame, voxels);
  }
}

// The expected cells are those given to the encoder. A cell of only NaN has no value in the file, which changes the
// tree of cells.
TEST(BrickDecode, GivesBackCells) {
  for (const VoxelType type : kAllTypes) {
    for (const bool with_nan : {false, true}) {
      SCOPED_TRACE(testing::Message() << nameOf(type) << (with_nan ? " with NaN" : ""));
      const BrickDesc frame = brickFrame(type);
      std::vector<std::byte> voxels = brickVoxels(frame);
      const int edge = static_cast<int>(frame.brick_size / kCellSize);
      if (with_nan) {
        withVoxelType(type, [&]<class T>(std::type_identity<T>) {
          if constexpr (std::is_floating_point_v<T>) {
            const Extent3 n = frame.stored().extent();
            T* const values = reinterpret_cast<T*>(voxels.data());
            std::fill_n(values, n.x * n.y * (frame.core().lo.z + kCellSize - frame.stored().lo.z), std::nan(""));
          }
        });
      }
      const std::vector<ValueRange> cells = cellRanges(voxels, type, frame.stored(), frame.core(), edge);
      const BrickBlock block = decodeBrick(frame, encodeBrick(frame, voxels, cells), "b.vdb");
      for (int i = 0; i < edge * edge * edge; ++i) {
        const ValueRange& found = block.octree.at(0, i % edge, i / edge % edge, i / edge / edge);
        EXPECT_EQ(found.lo, cells[static_cast<std::size_t>(i)].lo) << i;
        EXPECT_EQ(found.hi, cells[static_cast<std::size_t>(i)].hi) << i;
      }
    }
  }
}

// Earlier writers let Blosc split its blocks into byte planes.
TEST(BrickDecode, ReadsSplitBlocks) {
  for (const VoxelType type : kAllTypes) {
    SCOPED_TRACE(nameOf(type));
    const BrickDesc frame = brickFrame(type);
    const std::vector<std::byte> voxels = brickVoxels(frame), today = encodedBrick(frame, voxels);
    const std::filesystem::path directory = freshDirectory("split_blocks");
    FileSystem::real().writeAtomic(directory / "b.vdb", std::span<const std::byte>(today));
    blosc_set_splitmode(BLOSC_FORWARD_COMPAT_SPLIT);
    const std::vector<std::byte> split = writtenAgain(directory / "b.vdb");
    blosc_set_splitmode(BLOSC_NEVER_SPLIT);
    std::filesystem::remove_all(directory);
    ASSERT_NE(split.size(), today.size());
    expectBrickVoxels(decodeBrick(frame, split, "b.vdb"), frame, voxels);
  }
}

TEST(BrickDecode, RefusesLeavesThatAreNotTheBricks) {
  const BrickDesc frame = brickFrame(VoxelType::u16);
  const std::vector<std::byte> file = encodedBrick(frame, brickVoxels(frame));
  BrickDesc wider = frame, nearer = frame;
  wider.geometry.dims.x = 54;
  nearer.apron = 5;
  for (const auto& [expected, what] : {std::pair{wider, "density"}, {nearer, "apron"}}) {
    expectError([&] { decodeBrick(expected, file, "b.vdb"); }, ErrorCode::kDamaged,
                std::string(what) + " is not the tree of this brick's voxels");
  }
}

#ifdef OPENVDB_USE_DELAYED_LOADING
// Known: the bytes behind the head of Blosc's frame cannot be unpacked, and OpenVDB's reader would throw.
TEST(BrickDecode, HintForDelayedLoading_isNotUnpacked) {
  const BrickDesc frame = brickFrame(VoxelType::u16);
  const std::vector<std::byte> voxels = brickVoxels(frame);
  std::vector<std::byte> file = encodedBrick(frame, voxels);
  const auto type = std::as_bytes(std::span(kDelayedLoadType));
  const auto value = std::search(file.begin(), file.end(), type.begin(), type.end()) + std::ssize(type);
  ASSERT_LT(value, file.end());
  const auto numberAt = [](auto at) {
    std::uint32_t out;
    std::memcpy(&out, &*at, sizeof out);
    return out;
  };
  // Length of the value, number of leaves, 0 for masks of a byte each, the masks, length of the packed lengths.
  const auto packed = value + 12 + numberAt(value + 4);
  ASSERT_EQ(numberAt(value + 8), 0u);
  constexpr std::ptrdiff_t kBloscHead = 16;
  ASSERT_GT(numberAt(packed), kBloscHead);
  std::fill(packed + 4 + kBloscHead, packed + 4 + numberAt(packed), std::byte{0xff});
  expectBrickVoxels(decodeBrick(frame, file, "b.vdb"), frame, voxels);
}
#endif

// Damaged values and damaged lengths either throw an error with the file's name or decode to different values.
TEST(BrickDecode, DamagedFramesStayInTheirPlaces) {
  const BrickDesc frame = brickFrame(VoxelType::u16);
  const std::vector<std::byte> whole = encodedBrick(frame, brickVoxels(frame));
  constexpr std::array kHead = {std::byte{2}, std::byte{1}, std::byte{0x31}, std::byte{4}};
  std::vector<std::size_t> frames;
  for (auto at = whole.begin(); (at = std::search(at, whole.end(), kHead.begin(), kHead.end())) != whole.end(); ++at)
    frames.push_back(static_cast<std::size_t>(at - whole.begin()));
  ASSERT_GT(frames.size(), 100u);
  std::mt19937 random(3);
  int refused = 0;
  constexpr int kRounds = 60;
  for (int i = 0; i < kRounds; ++i) {
    std::vector<std::byte> file = whole;
    for (int n = 0; n < 3; ++n) {
      const std::size_t at = frames[random() % frames.size()] - 9 + random() % 57;
      file[std::min(at, file.size() - 1)] = static_cast<std::byte>(random());
    }
    try {
      decodeBrick(frame, file, "b.vdb");
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kDamaged);
      EXPECT_NE(std::string(error.what()).find("b.vdb"), std::string::npos);
      ++refused;
    }
  }
  EXPECT_GT(refused, 0);
  EXPECT_LT(refused, kRounds);
}

// Returns the offsets of the leaf frames of a grid, between the grid's name and the next grid's name.
std::vector<std::size_t> framesOf(const std::vector<std::byte>& file, const char* grid, const char* next) {
  const auto placeOf = [&](const std::string& name) {
    const auto bytes = std::as_bytes(std::span(name));
    return std::search(file.begin(), file.end(), bytes.begin(), bytes.end());
  };
  const auto end = next == nullptr ? file.end() : placeOf(next);
  std::vector<std::size_t> out;
  for (auto at = placeOf(grid); at + 16 < end; ++at) {
    if (at[0] != std::byte{2} || at[1] != std::byte{1} || at[3] != std::byte{4}) continue;
    // The length is stored twice, before the frame and in the frame's header.
    std::uint64_t outside;
    std::uint32_t inside;
    std::memcpy(&outside, &at[-8], sizeof outside);
    std::memcpy(&inside, &at[12], sizeof inside);
    if (outside == inside) out.push_back(static_cast<std::size_t>(at - file.begin()));
  }
  return out;
}

// OpenVDB and Blosc trust a leaf's length and write as many bytes.
TEST(BrickDecode, CellsThatSayTheyAreLongerAreRefused) {
  const BrickDesc frame = brickFrame(VoxelType::u16);
  const std::vector<std::byte> whole = encodedBrick(frame, brickVoxels(frame));
  for (const auto& [grid, next] :
       {std::pair{kCellMinGrid, kCellMaxGrid}, std::pair{kCellMaxGrid, static_cast<const char*>(nullptr)}}) {
    const std::vector<std::size_t> frames = framesOf(whole, grid, next);
    // Two frames belong to nodes that hold tiles, the last to the only leaf.
    ASSERT_EQ(frames.size(), 3u) << grid;
    // Offsets of lengths: bytes of the frame (before the frame), and in Blosc's header the unpacked and the packed
    // size.
    for (const int place : {-8, 4, 12}) {
      for (const std::int32_t length : {1, 1 << 20, std::numeric_limits<std::int32_t>::max()}) {
        std::vector<std::byte> file = whole;
        std::memcpy(&file[frames.back() + place], &length, sizeof length);
        SCOPED_TRACE(testing::Message() << grid << " " << place << " " << length);
        expectError([&] { decodeBrick(frame, file, "b.vdb"); }, ErrorCode::kDamaged, grid);
      }
    }
  }
}

// In the headers of the file and of its four grids, every four bytes are overwritten with a length of some GiB. Known
// result: an error or unchanged voxels. OpenVDB would clear as many bytes as the length before reading.
TEST(BrickDecode, HostileLengthsInMetadata_areRefusedInLittleMemory) {
  const BrickDesc frame = brickFrame(VoxelType::u16);
  const std::vector<std::byte> voxels = brickVoxels(frame), whole = encodedBrick(frame, voxels);
  const std::uint64_t before = peakResidentBytes();
  const std::string type = "Tree_int32_5_4_3";
  const auto bytes = std::as_bytes(std::span(type));
  int refused = 0;
  for (auto grid = whole.begin(); (grid = std::search(grid, whole.end(), bytes.begin(), bytes.end())) != whole.end();
       ++grid) {
    const auto at = static_cast<std::size_t>(grid - whole.begin());
    const std::size_t head = at < 512 ? 8 : at - 12;  // the first with the head of the file
    for (std::size_t place = head; place < at + 480; place += casesOf(3u, 16u)) {
      std::vector<std::byte> file = whole;
      const std::uint32_t length = place % 2 == 0 ? 0xfffffff4 : 0x70000000;
      std::memcpy(&file[place], &length, sizeof length);
      try {
        expectBrickVoxels(decodeBrick(frame, file, "b.vdb"), frame, voxels);
      } catch (const Error& error) {
        EXPECT_TRUE(error.code() == ErrorCode::kDamaged || error.code() == ErrorCode::kUnsupported) << error.what();
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, casesOf(100, 60));  // a fifth as many places under a sanitizer
  if (!kSanitized) {
    EXPECT_LT(peakResidentBytes() - before, 256u << 20);
  }
}

}  // namespace
}  // namespace kiln::test
