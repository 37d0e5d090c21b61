// The mask answers what a plain array of booleans answers, whatever was closed and whatever is asked.
#include <gtest/gtest.h>

#include <vector>

#include "occlusion/visibility.h"
#include "support/random_scene.h"

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

// Blobs that grow, as opaque surfaces do, so that both answers are common at every size of rectangle.
void agree(std::uint64_t seed, int questions) {
  Random random(seed);
  const int width = random.between(1, 300);
  const int height = random.between(1, 300);
  Plain plain(width, height);
  const auto mask = makeMaskVisibility(width, height);
  int hidden = 0;
  for (int i = 0; i < questions; ++i) {
    if (i % 4 == 0) {
      const int x0 = random.between(-20, width), y0 = random.between(-20, height);
      const int w = random.between(1, 90), h = random.between(1, 90);
      for (int y = std::max(y0, 0); y < std::min(y0 + h, height); ++y) {
        for (int x = std::max(x0, 0); x < std::min(x0 + w, width); ++x) {
          if (plain.closed(x, y) || random.chance(0.002)) continue;
          plain.close(x, y);
          mask->close(x, y);
        }
      }
    }
    const int x = random.between(-30, width + 10), y = random.between(-30, height + 10);
    const PixelRect rect{x, y, x + random.between(0, 1 << random.between(0, 8)),
                         y + random.between(0, 1 << random.between(0, 8))};
    ASSERT_EQ(mask->hidden(rect), plain.hidden(rect)) << "seed " << seed << " question " << i;
    hidden += plain.hidden(rect) ? 1 : 0;
  }
  EXPECT_GT(hidden, 0) << "seed " << seed;
}

TEST(MaskVisibility, AgreesWithBruteForce) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) agree(seed, 400);
}
TEST(MaskVisibility, NightlyAgreesWithBruteForceOften) {
  for (std::uint64_t seed = 1000; seed < 7000; ++seed) agree(seed, 400);
}

}  // namespace
}  // namespace kiln::test
