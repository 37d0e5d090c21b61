// Against the definition, pixel by pixel: a window's blocks are those of its pixels in the tile, and it is open where
// one of them is.
#include "splat/tile_windows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/procedural.h"

namespace kiln::test {
namespace {

class Definition {
 public:
  explicit Definition(const PixelRect& rect) : rect_(rect), rgba_(std::size_t{4} * kSweepEdge * kSweepEdge) {}
  TilePixels tile() { return {rect_, rgba_.data(), std::ptrdiff_t{4} * kSweepEdge, nullptr, {}}; }
  bool open(int x, int y) const { return rgba_[indexOf(x, y)] != 1; }
  void close(int x, int y) { rgba_[indexOf(x, y)] = 1; }

  // How many windows `windows` knows otherwise.
  int wrong(const TileWindows& windows, int taps) const {
    int out = 0;
    for (int y = 0; y < rect_.height() + taps - 1; ++y) {
      for (int x = 0; x < rect_.width() + taps - 1; ++x) {
        std::uint64_t blocks = 0;
        bool is_open = false;
        for (int py = std::max(y - taps + 1, 0); py <= std::min(y, rect_.height() - 1); ++py) {
          for (int px = std::max(x - taps + 1, 0); px <= std::min(x, rect_.width() - 1); ++px) {
            blocks |= std::uint64_t{1} << (py / 8 * 8 + px / 8);
            is_open = is_open || open(px, py);
          }
        }
        const FootprintPlace at{x + (y << 16), 0};
        out += windows.blocks(at) != blocks || windows.open(at) != is_open ? 1 : 0;
      }
    }
    return out;
  }

  // How many pixels, and how many of some rectangles, `windows` knows otherwise.
  int wrongPixels(const TileWindows& windows) const {
    int out = 0;
    for (int y = 0; y < rect_.height(); ++y) {
      for (int x = 0; x < rect_.width(); ++x) {
        out += (windows.openPixels(x & ~7, y) >> (x & 7) & 1) != (open(x, y) ? 1u : 0u) ? 1 : 0;
        const PixelRect part = {x, y, std::min(x + 1 + y % 5, rect_.width()), std::min(y + 1 + x % 3, rect_.height())};
        bool all = true;
        for (int py = part.y0; py < part.y1; ++py) {
          for (int px = part.x0; px < part.x1; ++px) all = all && open(px, py);
        }
        out += windows.allOpen(part) != all ? 1 : 0;
      }
    }
    return out;
  }

 private:
  static std::size_t indexOf(int x, int y) { return static_cast<std::size_t>(4 * (y * kSweepEdge + x) + 3); }
  PixelRect rect_;
  std::vector<float> rgba_;
};

TEST(TileWindows, KnowBlocksAndWhatIsOpen) {
  for (const PixelRect& rect : {PixelRect{64, 0, 128, 64}, PixelRect{3, 5, 40, 22}, PixelRect{7, 7, 8, 8}}) {
    for (const int taps : {3, 4, 6, 17, kMostWholeTaps}) {
      if (taps > 6 && rect.width() > 40) continue;  // a long sum
      SCOPED_TRACE(testing::Message() << rect.width() << " x " << rect.height() << ", " << taps << " taps");
      Definition truth(rect);
      TileWindows windows;
      std::uint64_t seed = 0;
      const auto closeMany = [&](double share, const auto& close) {
        for (int y = 0; y < rect.height(); ++y) {
          for (int x = 0; x < rect.width(); ++x) {
            if (truth.open(x, y) && hashUnit(7, seed++) < share) close(x, y);
          }
        }
      };
      closeMany(0.7, [&](int x, int y) { truth.close(x, y); });
      windows.reset(truth.tile(), taps);
      EXPECT_EQ(truth.wrong(windows, taps), 0);
      for (const double share : {0.01, 0.8, 1.0}) {
        closeMany(share, [&](int x, int y) {
          truth.close(x, y);
          windows.close(x, y);
        });
        windows.update();
        EXPECT_EQ(truth.wrong(windows, taps), 0);
        EXPECT_EQ(truth.wrongPixels(windows), 0);
      }
    }
  }
}

// Of footprints that are clipped none is called closed that is not, and all are where nothing is left.
TEST(TileWindows, OfClippedFootprintsAreOpenTillTheLastPixelCloses) {
  Definition truth({0, 0, 40, 30});
  TileWindows windows;
  for (const int taps : {kMostWholeTaps + 1, 500, 4096}) {
    windows.reset(truth.tile(), taps);
    EXPECT_LT(windows.bytes(), 200000u) << taps;
    const auto openAt = [&](int x, int y) { return windows.open({x + (y << 16), 0}); };
    for (int y = 0; y < 30; ++y) {
      for (int x = 0; x < 40; ++x) {
        if (x < 39 || y < 29) windows.close(x, y);
      }
    }
    windows.update();
    for (const int at : {0, 17, taps - 1, taps + 28}) EXPECT_TRUE(openAt(at, at)) << taps << ", " << at;
    windows.close(39, 29);
    windows.update();
    for (const int at : {0, 17, taps - 1, taps + 28}) EXPECT_FALSE(openAt(at, at)) << taps << ", " << at;
  }
}

}  // namespace
}  // namespace kiln::test
