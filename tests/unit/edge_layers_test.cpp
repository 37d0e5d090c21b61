// Layers of pixels that slabs cover in part. Known because slabs laid one behind the other, in one go, are what a
// partial image's layers must be when they are laid behind another part's.
#include "base/edge_layers.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/random_scene.h"

namespace kiln::test {
namespace {

struct Pixel {
  float rgba[4] = {};
  float covered = 0;
  void lay(const EdgeLayer& layer) { layBehind(layer, rgba, covered); }
};

EdgeLayer randomSlab(Random& random, bool whole) {
  EdgeLayer out{whole ? 1.0f : static_cast<float>(random.uniform(0.02, 0.99)), {}};
  out.rgba[3] = static_cast<float>(random.uniform(0.05, 0.9));
  for (int c = 0; c < 3; ++c)
    out.rgba[static_cast<std::size_t>(c)] = out.rgba[3] * static_cast<float>(random.uniform(0, 1));
  return out;
}

TEST(EdgeLayers, BehindOthersAreTheSlabsOneByOne) {
  Random random(41);
  int listed = 0;
  for (int trial = 0; trial < 300; ++trial) {
    EdgeLayers layers({3, 5, 4, 6});
    Pixel behind, alone, one_by_one;
    for (std::int64_t i = random.between(0, 4); i > 0; --i) {
      const EdgeLayer slab = randomSlab(random, false);
      behind.lay(slab);
      one_by_one.lay(slab);
    }
    const std::int64_t slabs = random.between(1, 9);
    for (std::int64_t i = 0; i < slabs; ++i) {
      const EdgeLayer slab = randomSlab(random, random.between(0, 3) == 0);
      layers.add(3, 5, slab, alone.rgba[3]);
      alone.lay(slab);
      one_by_one.lay(slab);
    }
    if (layers.count(3, 5) == 0) {
      // Its first slab covers it, so that its colour is a layer.
      behind.lay({1, {alone.rgba[0], alone.rgba[1], alone.rgba[2], alone.rgba[3]}});
    } else {
      ++listed;
      layers.forEach(3, 5, [&](const EdgeLayer& layer) { behind.lay(layer); });
    }
    for (int c = 0; c < 4; ++c) ASSERT_NEAR(behind.rgba[c], one_by_one.rgba[c], 1e-5) << trial;
    ASSERT_EQ(behind.covered, one_by_one.covered);
  }
  EXPECT_GT(listed, 150);
}

// Eroded silhouettes: an opaque body's edge behind its own front edge is hidden; beside it, it is not.
TEST(EdgeLayers, HideWhatLiesBehindThemAndNotWhatLiesBeside) {
  Pixel pixel;
  pixel.lay({0.5f, {0, 0, 0, 1}});
  pixel.lay({0.25f, {0, 0, 0, 1}});
  EXPECT_NEAR(pixel.rgba[3], 0.5, 0.01);
  pixel.lay({0.75f, {0, 0, 0, 1}});
  EXPECT_NEAR(pixel.rgba[3], 0.75, 0.01);
  pixel.lay({1, {0, 0, 0, 1}});
  EXPECT_NEAR(pixel.rgba[3], 1, 1e-6);
}

TEST(EdgeLayers, ThatAreMoreThanThereIsRoomForSayIt) {
  Random random(42);
  const PixelRect rect{0, 0, 8, 8};
  EdgeLayers layers(rect, EdgeLayers::kLeastPixelBytes);
  Pixel alone;
  for (int i = 0; i < 200; ++i) {
    const EdgeLayer slab = randomSlab(random, false);
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 8; ++x) layers.add(x, y, slab, alone.rgba[3]);
    }
    alone.lay(slab);
  }
  EXPECT_TRUE(layers.incomplete());
  EXPECT_FALSE(EdgeLayers(rect).incomplete());
  int listed = 0;
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) {
      Pixel pixel;
      if (layers.count(x, y) == 0) continue;
      ++listed;
      layers.forEach(x, y, [&](const EdgeLayer& layer) { pixel.lay(layer); });
      for (int c = 0; c < 4; ++c) ASSERT_NEAR(pixel.rgba[c], alone.rgba[c], 0.05) << x << ", " << y;
    }
  }
  EXPECT_GT(listed, 10);
}

}  // namespace
}  // namespace kiln::test
