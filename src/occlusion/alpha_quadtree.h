// Alpha quadtree: the standard squares of the image, each with the count of its opaque quarters. Invariant: a square's
// count is four exactly where all its pixels are opaque; what of a square lies outside of the image counts as opaque.
// Source: Lee and Ihm §2.3.1 and §2.3.2; the structure is Meagher's (1982). Departs from the paper in that images need
// be neither square nor powers of two. Two tests ask it: overlay.cpp and quadtree.cpp.
#pragma once

#include <cstdint>
#include <vector>

#include "occlusion/visibility.h"

namespace kiln {

class AlphaQuadtree {
 public:
  AlphaQuadtree(int width, int height);

  /// The level of the one square that holds the image; a square of level k is 2^k pixels wide.
  int top() const { return static_cast<int>(levels_.size()) - 1; }
  /// Whether the square in column x and row y of its level is opaque. Outside of the image everything is.
  bool opaque(int level, int x, int y) const {
    const Level& squares = levels_[static_cast<std::size_t>(level)];
    if (x < 0 || y < 0 || x >= squares.columns || y >= squares.rows) return true;
    return squares.counts[static_cast<std::size_t>(y) * squares.columns + x] == kOpaque;
  }
  /// cost: O(log n) at worst, 4/3 steps a pixel over a whole image.
  void close(int x, int y);

 private:
  static constexpr std::uint8_t kOpaque = 4;
  struct Level {
    int columns, rows;
    std::vector<std::uint8_t> counts;
  };
  std::vector<Level> levels_;
};

/// Where the squares that judge a rectangle may lie: in its tile where tiles are drawn at the same time, so that no
/// answer depends on what another thread has done.
struct SquareBounds {
  PixelRect pixels;
  bool tiled = false;
};
SquareBounds squareBoundsOf(const PixelRect& rect, int tile_px, const PixelRect& image);

}  // namespace kiln
