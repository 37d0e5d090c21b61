// The number of bricks drawn at a time changes only how long threads wait for each other, not the picture. Known from
// frames drawn brick after brick. Bricks in work stay in memory and leave room to read ahead.
#include <gtest/gtest.h>

#include "base/thread/parallel.h"
#include "frame/frame_memory.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/system/sanitized.h"
#include "support/volumes/procedural.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

class BricksTogether : public ::testing::TestWithParam<Lattice> {};

TEST_P(BricksTogether, ChangeNoBit) {
  const DenseVolume volume = head({{50, 41, 37}, VoxelType::i16, obliqueAffine()}, usualRange(VoxelType::i16));
  const StoreReader store(makeStore(volume, "together", 16));
  const ThreadLimit threads(2);
  BrickCache cache(store, 1u << 30);
  Progress silent;
  for (std::uint64_t seed = 60; seed < casesOf(66u, 62u); ++seed) {
    FrameRequest request = requestOf(randomScene(seed, volume, {97, 83}), GetParam(), randomThreshold(seed));
    request.bricks_together = 1;
    FrameStatistics alone;
    const Image truth = renderFrame(cache, request, silent, alone);
    // All bricks of the volume are in memory now.
    for (const int together : {2, 5, 32}) {
      request.bricks_together = together;
      FrameStatistics statistics;
      EXPECT_TRUE(equalBits(truth, renderFrame(cache, request, silent, statistics))) << seed << ' ' << together;
      EXPECT_EQ(statistics.voxels_splats, alone.voxels_splats) << seed << ' ' << together;
      EXPECT_EQ(statistics.bricks_contributing, alone.bricks_contributing) << seed << ' ' << together;
    }
  }
}

TEST_P(BricksTogether, LeaveRoomToReadAhead) {
  RenderJob job;
  job.volume = makeStore(head({{50, 41, 37}, VoxelType::u8, obliqueAffine()}, usualRange(VoxelType::u8)), "room", 16);
  job.picture.size = {200, 180};
  job.picture.samples = 1;
  job.picture.lattice = GetParam();
  const ThreadLimit threads(2);
  const StoreReader store(job.volume);
  const std::uint64_t least = frameMemory(store, job).smallest();
  int most = 1;
  for (std::uint64_t budget = least; budget < 64 * least; budget += budget / 16) {
    job.speed.memory_bytes = budget;
    const FrameMemory memory = frameMemory(store, job);
    ASSERT_LE(memory.besideBricks() + memory.brick, budget);
    const auto held = static_cast<std::uint64_t>(memory.bricks_together) * memory.brick;
    if (memory.bricks_together > kEnoughBricksTogether) {
      EXPECT_LE(2 * held, budget - memory.besideBricks()) << budget;
    }
    most = memory.bricks_together;
  }
  EXPECT_EQ(most, kMostBricksTogether);
}

// Squares of tiles that lie in several blocks of the mask, and small tiles beside them. Known from single tiles of one
// thread that hide nothing.
TEST(JoinedTiles, ChangeNoBit) {
  const DenseVolume volume = head({{50, 41, 37}, VoxelType::i16, obliqueAffine()}, usualRange(VoxelType::i16));
  const StoreReader store(makeStore(volume, "joined", 16));
  BrickCache cache(store, 1u << 30);
  Progress silent;
  for (std::uint64_t seed = 70; seed < casesOf(73u, 71u); ++seed) {
    FrameRequest request = requestOf(randomScene(seed, volume, {700, 600}), Lattice::kPixel, randomThreshold(seed));
    request.crop = PixelRect{70, 133, 690, 600};
    request.visibility.method = VisibilityMethod::kNone;
    request.tile_px = 0;
    FrameStatistics ignored;
    const Image truth = renderFrame(cache, request, silent, ignored);
    for (const unsigned count : {2u, 5u}) {
      const ThreadLimit threads(count);
      request.tile_px = count == 2 ? 64 : 128;
      for (const VisibilityMethod method : {VisibilityMethod::kMask, VisibilityMethod::kRangeTree}) {
        request.visibility.method = method;
        EXPECT_TRUE(equalBits(truth, renderFrame(cache, request, silent, ignored)))
            << seed << ' ' << count << ' ' << static_cast<int>(method);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Of, BricksTogether, ::testing::Values(Lattice::kPixel, Lattice::kVoxel));

}  // namespace
}  // namespace kiln::test
