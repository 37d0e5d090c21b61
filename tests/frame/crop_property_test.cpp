// A crop equals the corresponding rectangle of the whole picture to the bit. Known from the whole picture, for random
// volumes, scenes, methods and rectangles.
#include <gtest/gtest.h>

#include "base/error.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/system/expect_error.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr ImageSize kCroppedSize{90, 75};  // neither is a multiple of a tile
constexpr VisibilityMethod kExact[] = {VisibilityMethod::kMask, VisibilityMethod::kNone, VisibilityMethod::kRangeTree,
                                       VisibilityMethod::kOverlay};

// Rectangles: a single pixel, a tile's last row, from a tile's border into a tile, no border on a tile's border, the
// whole picture.
std::vector<PixelRect> cropsOf(std::uint64_t seed) {
  Random random(seed ^ 0x63726f70);
  const auto one = [&](int from, int to) { return random.between(from, to - 1); };
  const int x = one(0, kCroppedSize.width), y = one(0, kCroppedSize.height);
  return {{x, y, x + 1, y + 1},
          {one(0, 20), 63, one(60, kCroppedSize.width), 64},
          {64, 0, 64 + one(1, 26), 64},
          {one(1, 63), one(1, 63), one(66, kCroppedSize.width), one(66, kCroppedSize.height)},
          {0, 0, kCroppedSize.width, kCroppedSize.height}};
}

class Crop : public ::testing::TestWithParam<Lattice> {
 protected:
  void check(std::uint64_t first_seed, int scenes) {
    const DenseVolume volume = head({{40, 51, 37}, VoxelType::u8, anisotropicAffine()}, usualRange(VoxelType::u8));
    const auto store = makeStore(volume, "crop", 16);
    const StoreReader reader(store);
    int with_something = 0;
    for (int i = 0; i < scenes; ++i) {
      const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(i);
      const RandomScene scene = randomScene(seed, volume, kCroppedSize);
      FrameRequest request = requestOf(scene, GetParam(), randomThreshold(seed));
      if (request.background == Background{}) request.background = {{0.1, 0.2, 0.3, 0.5}, {0.7, 0, 0.1, 1}};
      if (seed % 4 == 0) request.aovs = {true, true};
      FrameStatistics statistics;
      const Image whole = draw(store, request, 1ull << 30, &statistics);
      with_something += statistics.bricks_contributing > 0 ? 1 : 0;
      std::uint64_t turn = seed;
      for (const PixelRect& crop : cropsOf(seed)) {
        request.crop = crop;
        request.visibility.method = kExact[turn % std::size(kExact)];
        request.tile_px = turn % 3 == 0 ? 0 : 64 << turn % 2;
        EXPECT_TRUE(equalBits(partOf(whole, crop), draw(store, request, 1ull << 30, &statistics)))
            << "seed " << seed << ", crop " << crop.x0 << " " << crop.y0 << " " << crop.x1 << " " << crop.y1
            << ", method " << static_cast<int>(request.visibility.method) << ", tiles of " << request.tile_px;
        // Each brick in view is drawn or hidden, though nodes of the walk lie across the crop.
        BrickWalkCounts ignored;
        std::uint64_t drawn = 0;
        for (const LevelStatistics& level : statistics.levels) drawn += level.bricks;
        EXPECT_EQ(drawn + statistics.bricks_hidden, bricksInView({&reader}, request, ignored).size())
            << "seed " << seed;
        ++turn;
      }
    }
    EXPECT_GT(with_something, scenes / 2);
  }
};

TEST_P(Crop, IsThatPartOfTheWhole) { check(300, 4); }
TEST_P(Crop, NightlyIsThatPartOfTheWholeForManyScenes) { check(3000, 300); }

INSTANTIATE_TEST_SUITE_P(Lattices, Crop, ::testing::ValuesIn(kLattices));

TEST(Crops, ThatAreNotInThePictureAreRefused) {
  const ImageSize size{150, 131};
  EXPECT_EQ(drawnPixels(size, std::nullopt), (PixelRect{0, 0, 150, 131}));
  EXPECT_EQ(drawnPixels(size, PixelRect{149, 130, 150, 131}), (PixelRect{149, 130, 150, 131}));
  for (const PixelRect& wrong :
       {PixelRect{0, 0, 0, 5}, {-1, 0, 5, 5}, {0, 0, 151, 5}, {3, 131, 4, 132}, {5, 5, 4, 6}}) {
    expectError([&] { drawnPixels(size, wrong); }, ErrorCode::kUsage, "");
  }
}

}  // namespace
}  // namespace kiln::test
