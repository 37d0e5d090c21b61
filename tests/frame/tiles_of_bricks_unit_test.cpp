// Tiles that share the work of bricks out: every pixel of every brick once, borders at multiples of a tile, and large
// tiles before small tiles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "frame/pass/tiles_of_bricks.h"
#include "occlusion/visibility.h"

namespace kiln::test {
namespace {

constexpr int kTileEdge = kVisibilityTile;
constexpr std::uint64_t kSingleTiles = ~std::uint64_t{0};

std::vector<PixelRect> someBricks() {
  std::mt19937 random(7);
  const auto below = [&](int end) { return static_cast<int>(random() % static_cast<unsigned>(end)); };
  std::vector<PixelRect> out;
  for (int i = 0; i < 12; ++i) {
    const int x = below(900) - 40, y = below(700) - 40;
    out.push_back({x, y, x + 1 + below(400), y + 1 + below(300)});
  }
  return out;
}

TEST(TilesOfBricks, HoldEachPixelOfEachBrickOnce) {
  const std::vector<PixelRect> bricks = someBricks();
  for (const PixelRect& drawn : {PixelRect{0, 0, 1000, 800}, PixelRect{130, 70, 655, 777}, PixelRect{5, 5, 6, 6}}) {
    for (const std::uint64_t parts : {std::uint64_t{1}, std::uint64_t{4}, std::uint64_t{32}, kSingleTiles}) {
      std::vector<int> held(static_cast<std::size_t>(1000) * 800);
      for (const TileOfBricks& tile : tilesOfBricks(bricks, drawn, kTileEdge, parts)) {
        EXPECT_TRUE(drawn.contains(tile.rect));
        EXPECT_TRUE(tile.rect.x0 % kTileEdge == 0 || tile.rect.x0 == drawn.x0);
        EXPECT_TRUE(tile.rect.y0 % kTileEdge == 0 || tile.rect.y0 == drawn.y0);
        EXPECT_TRUE(tile.rect.x1 % kTileEdge == 0 || tile.rect.x1 == drawn.x1);
        EXPECT_TRUE(tile.rect.y1 % kTileEdge == 0 || tile.rect.y1 == drawn.y1);
        EXPECT_TRUE(std::is_sorted(tile.bricks.begin(), tile.bricks.end()));
        std::uint64_t pixels = 0;
        for (const std::size_t brick : tile.bricks) {
          const PixelRect common = intersection(bricks[brick], tile.rect);
          ASSERT_FALSE(common.empty());
          pixels += common.count();
          for (int y = common.y0; y < common.y1; ++y) {
            for (int x = common.x0; x < common.x1; ++x) ++held[static_cast<std::size_t>(1000 * y + x)];
          }
        }
        EXPECT_EQ(tile.pixels, pixels);
      }
      for (int y = 0; y < 800; ++y) {
        for (int x = 0; x < 1000; ++x) {
          const auto touches = [&](const PixelRect& brick) { return drawn.contains(x, y) && brick.contains(x, y); };
          ASSERT_EQ(held[static_cast<std::size_t>(1000 * y + x)], std::count_if(bricks.begin(), bricks.end(), touches))
              << x << ' ' << y;
        }
      }
    }
  }
}

TEST(TilesOfBricks, JoinOnlyASmallPartOfTheWorkThatIsLeft) {
  const std::vector<PixelRect> bricks = someBricks();
  const PixelRect drawn{0, 0, 1000, 800};
  std::uint64_t left = 0;
  for (const PixelRect& brick : bricks) left += intersection(brick, drawn).count();
  bool joins = false;
  for (const TileOfBricks& tile : tilesOfBricks(bricks, drawn, kTileEdge, 4)) {
    const bool joined = tile.rect.width() > kTileEdge || tile.rect.height() > kTileEdge;
    EXPECT_LE(tile.pixels, joined ? left / 4 : left);
    EXPECT_LE(std::max(tile.rect.width(), tile.rect.height()), kMostJoined_px);
    joins = joins || joined;
    left -= tile.pixels;
  }
  EXPECT_EQ(left, 0u);
  EXPECT_TRUE(joins);
}

TEST(TilesOfBricks, AreSingleOrAllIfAskedFor) {
  const std::vector<PixelRect> bricks = someBricks();
  const PixelRect drawn{0, 0, 1000, 800};
  for (const TileOfBricks& tile : tilesOfBricks(bricks, drawn, kTileEdge, kSingleTiles)) {
    EXPECT_LE(tile.rect.width(), kTileEdge);
    EXPECT_LE(tile.rect.height(), kTileEdge);
  }
  for (const int tile_px : {kTileEdge, 0}) {
    const PixelRect small = tile_px == 0 ? drawn : PixelRect{70, 5, kMostJoined_px, 500};
    const std::vector<TileOfBricks> whole = tilesOfBricks(bricks, small, tile_px, 1);
    ASSERT_EQ(whole.size(), 1u);
    EXPECT_EQ(whole.front().rect, small);
  }
  EXPECT_TRUE(tilesOfBricks({}, drawn, kTileEdge, 4).empty());
}

}  // namespace
}  // namespace kiln::test
