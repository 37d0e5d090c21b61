// Problem. Tests of occlusion need to know whether a square of the image is opaque.
// Method. A quadtree over the image: each standard square counts its opaque quarters.
// Invariant. A count is four exactly if all pixels of the square are opaque; the part of a square outside the image
// counts as opaque.
// Source: Lee and Ihm §2.3.1 and §2.3.2; the structure is Meagher's (1982).
// Differs: images need be neither square nor powers of two.
// Used by overlay.cpp and quadtree.cpp.
#pragma once

#include <cstdint>
#include <vector>

#include "occlusion/visibility.h"

namespace kiln {

class AlphaQuadtree {
 public:
  AlphaQuadtree(int width, int height);

  /// The level of the single square that holds the image; a square of level k is 2^k pixels wide.
  int top() const { return static_cast<int>(levels_.size()) - 1; }
  /// True if the square in column x and row y of its level is opaque; squares outside the image are opaque.
  bool opaque(int level, int x, int y) const {
    const Level& squares = levels_[static_cast<std::size_t>(level)];
    if (x < 0 || y < 0 || x >= squares.columns || y >= squares.rows) return true;
    return squares.counts[static_cast<std::size_t>(y) * squares.columns + x] == kOpaque;
  }
  /// Marks a pixel as opaque. cost: O(log n) at worst, 4/3 steps per pixel over a whole image.
  void close(int x, int y);

 private:
  static constexpr std::uint8_t kOpaque = 4;
  struct Level {
    int columns, rows;
    std::vector<std::uint8_t> counts;
  };
  std::vector<Level> levels_;
};

/// The region in which the squares that test a rectangle may lie. With tiles drawn in parallel the region is the tile,
/// so that no result depends on the progress of another thread.
struct SquareBounds {
  PixelRect pixels;
  bool tiled = false;
};
SquareBounds squareBoundsOf(const PixelRect& rect, int tile_px, const PixelRect& image);

}  // namespace kiln
