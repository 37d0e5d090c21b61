// Every visibility method agrees with a plain array of booleans, for random closed pixels and queries. Exact methods
// test whether the rectangle is opaque; the overlay tests its four enclosing squares. The quadtree tests its
// approximate projected area, found here by trying every position.
#include <gtest/gtest.h>

#include <functional>
#include <ostream>
#include <vector>

#include "occlusion/visibility.h"
#include "support/volumes/random_scene.h"

namespace kiln::test {
namespace {

class Plain {
 public:
  Plain(int width, int height) : width_(width), height_(height), closed_(static_cast<std::size_t>(width) * height) {}
  bool closed(int x, int y) const { return closed_[static_cast<std::size_t>(y) * width_ + x]; }
  void close(int x, int y) { closed_[static_cast<std::size_t>(y) * width_ + x] = true; }
  bool hidden(const PixelRect& rect) const {
    for (int y = std::max(rect.y0, 0); y < std::min(rect.y1, height_); ++y) {
      for (int x = std::max(rect.x0, 0); x < std::min(rect.x1, width_); ++x) {
        if (!closed(x, y)) return false;
      }
    }
    return true;
  }

 private:
  int width_, height_;
  std::vector<bool> closed_;
};

// Returns the expected answer of a method, by counting pixels.
using Judge = std::function<bool(const Plain&, const PixelRect& rect, const PixelRect& image)>;

struct Method {
  const char* name;
  std::unique_ptr<Visibility> (*make)(int width, int height);
  Judge judge;
};
void PrintTo(const Method& method, std::ostream* out) { *out << method.name; }

bool exactly(const Plain& plain, const PixelRect& rect, const PixelRect&) { return plain.hidden(rect); }

// Meagher's overlays: squares whose edge is the least power of two that covers the rectangle; the square of its first
// pixel and the next along both axes.
bool overlaid(const Plain& plain, const PixelRect& wanted, const PixelRect& image) {
  const PixelRect rect = intersection(wanted, image);
  if (rect.empty()) return true;
  int square = 1;
  while (square < std::max(rect.x1 - rect.x0, rect.y1 - rect.y0)) square *= 2;
  const int x = rect.x0 / square * square, y = rect.y0 / square * square;
  return plain.hidden({x, y, x + 2 * square, y + 2 * square});
}

// The block of two by two squares that covers most of the enlarged rectangle: every position is tried.
template <int kEpsilon>
bool approximated(const Plain& plain, const PixelRect& wanted, const PixelRect& image) {
  const PixelRect rect = intersection(wanted, image);
  if (rect.empty()) return true;
  const int edge = std::max(rect.x1 - rect.x0, rect.y1 - rect.y0) + 2 * kEpsilon;
  int square = 1;
  while (2 * square < edge && square < std::max(image.x1, image.y1)) square *= 2;
  const auto best = [&](int lo, int hi) {
    // The nearest centre, of two the upper, covers as much as any other position of the block.
    int best = 0;
    for (int boundary = 0; boundary <= hi + 2 * square; boundary += square) {
      if (std::abs(lo + hi - 2 * boundary) <= std::abs(lo + hi - 2 * best)) best = boundary;
    }
    return best;
  };
  const int x = best(rect.x0, rect.x1), y = best(rect.y0, rect.y1);
  return plain.hidden({x - square, y - square, x + square, y + square});
}

// Growing blobs, as opaque surfaces grow, so that both answers are frequent at every size of rectangle.
void agree(const Method& method, std::uint64_t seed, int questions) {
  Random random(seed);
  const int largest = seed % 8 == 0 ? 1300 : 300;  // several blocks of the mask
  const int width = random.between(1, largest);
  const int height = random.between(1, largest);
  Plain plain(width, height);
  const auto visibility = method.make(width, height);
  int hidden = 0;
  for (int i = 0; i < questions; ++i) {
    if (i % 4 == 0) {
      const int x0 = random.between(-20, width), y0 = random.between(-20, height);
      const int w = random.between(1, largest / 3), h = random.between(1, largest / 3);
      for (int y = std::max(y0, 0); y < std::min(y0 + h, height); ++y) {
        for (int x = std::max(x0, 0); x < std::min(x0 + w, width); ++x) {
          if (plain.closed(x, y) || random.chance(0.0005)) continue;
          plain.close(x, y);
          visibility->close(x, y);
        }
      }
    }
    const int x = random.between(-30, width + 10), y = random.between(-30, height + 10);
    const PixelRect rect{x, y, x + random.between(0, 1 << random.between(0, 8)),
                         y + random.between(0, 1 << random.between(0, 8))};
    const bool truth = method.judge(plain, rect, {0, 0, width, height});
    ASSERT_EQ(visibility->hidden(rect), truth) << "seed " << seed << " question " << i;
    hidden += truth ? 1 : 0;
  }
  EXPECT_GT(hidden, 0) << "seed " << seed;
}

class VisibilityMethods : public ::testing::TestWithParam<Method> {};

TEST_P(VisibilityMethods, AgreeWithBruteForce) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) agree(GetParam(), seed, 400);
}
TEST_P(VisibilityMethods, NightlyAgreeWithBruteForceOften) {
  for (std::uint64_t seed = 1000; seed < 6000; ++seed) agree(GetParam(), seed, 400);
}

INSTANTIATE_TEST_SUITE_P(
    All, VisibilityMethods,
    ::testing::Values(Method{"mask", makeMaskVisibility, exactly},
                      Method{"range_tree", makeRangeTreeVisibility, exactly},
                      Method{"overlay", [](int w, int h) { return makeOverlayVisibility(w, h); }, overlaid},
                      Method{"quadtree", [](int w, int h) { return makeQuadtreeVisibility(w, h); }, approximated<0>},
                      Method{"quadtree_enlarged", [](int w, int h) { return makeQuadtreeVisibility(w, h, 5); },
                             approximated<5>}),
    [](const auto& info) { return std::string(info.param.name); });

// Inside a tile the tested squares lie in the tile, or outside the image, so that no answer depends on other threads'
// pixels. Closing all other pixels changes no answer.
TEST(TiledVisibility, DoesNotLookOutsideOfTheTile) {
  constexpr int kWidth = 300, kHeight = 200, kTile = 64;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed);
    std::unique_ptr<Visibility> alone[] = {makeOverlayVisibility(kWidth, kHeight, kTile),
                                           makeQuadtreeVisibility(kWidth, kHeight, random.between(0, 40), kTile)};
    random = Random(seed);
    std::unique_ptr<Visibility> beside[] = {makeOverlayVisibility(kWidth, kHeight, kTile),
                                            makeQuadtreeVisibility(kWidth, kHeight, random.between(0, 40), kTile)};
    const int tx = random.between(0, kWidth / kTile) * kTile, ty = random.between(0, kHeight / kTile) * kTile;
    const PixelRect tile = intersection(PixelRect{tx, ty, tx + kTile, ty + kTile}, PixelRect{0, 0, kWidth, kHeight});
    const double open = random.uniform(0, 0.01);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (tile.contains(x, y) && random.chance(open)) continue;
        for (int i = 0; i < 2; ++i) {
          if (tile.contains(x, y)) alone[i]->close(x, y);
          beside[i]->close(x, y);
        }
      }
    }
    for (int question = 0; question < 200; ++question) {
      const int x0 = random.between(tile.x0, tile.x1 - 1), y0 = random.between(tile.y0, tile.y1 - 1);
      const PixelRect rect{x0, y0, random.between(x0 + 1, tile.x1), random.between(y0 + 1, tile.y1)};
      for (int i = 0; i < 2; ++i) ASSERT_EQ(alone[i]->hidden(rect), beside[i]->hidden(rect)) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace kiln::test
