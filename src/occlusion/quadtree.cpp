// Problem. The test of a rectangle in O(1) that finds more hidden rectangles than overlay.cpp.
// Method. Four adjacent standard squares approximate the rectangle: the 2×2 block around the corner nearest to the
// rectangle's centre, on the lowest level whose block is no smaller than the rectangle.
// Limit. Not exact: the block may miss up to a quarter of its edge on one side, and a node visible only there is lost.
// ε enlarges the rectangle on every side before the squares are chosen; from ε of half the rectangle's edge on, the
// block surely encloses the rectangle.
// Source: Lee and Ihm §2.3.3, Figure 6; ε is future work there (§3.3).
// Differs for tiles drawn in parallel: a rectangle inside a tile is tested by squares inside the tile.
// Cost: O(1).
#include <bit>

#include "occlusion/alpha_quadtree.h"

namespace kiln {
namespace {

// The two adjacent squares along one axis.
struct Pair {
  int first, last;
};

class QuadtreeVisibility final : public Visibility {
 public:
  QuadtreeVisibility(int width, int height, int epsilon_px, int tile_px)
      : image_{0, 0, width, height}, epsilon_px_(epsilon_px), tile_px_(tile_px), tree_(width, height) {}

  bool hidden(const PixelRect& wanted) const override {
    const PixelRect rect = intersection(wanted, image_);
    if (rect.empty()) return true;
    const auto edge = static_cast<unsigned>(std::max(rect.x1 - rect.x0, rect.y1 - rect.y0) + 2 * epsilon_px_);
    // The lowest level with 2 · 2^level >= edge.
    const SquareBounds bounds = squareBoundsOf(rect, tile_px_, image_);
    const int highest = bounds.tiled ? std::countr_zero(static_cast<unsigned>(tile_px_)) : tree_.top();
    const int level = std::min({std::max(static_cast<int>(std::bit_width(edge - 1)) - 1, 0), highest, tree_.top()});
    const Pair x = around(rect.x0, rect.x1, level, bounds.tiled, bounds.pixels.x0, bounds.pixels.x1);
    const Pair y = around(rect.y0, rect.y1, level, bounds.tiled, bounds.pixels.y0, bounds.pixels.y1);
    return tree_.opaque(level, x.first, y.first) && tree_.opaque(level, x.last, y.first) &&
           tree_.opaque(level, x.first, y.last) && tree_.opaque(level, x.last, y.last);
  }

  void close(int x, int y) override { tree_.close(x, y); }

 private:
  // The squares on both sides of the boundary nearest to the centre of [lo, hi); inside [from, to) if tiled.
  static Pair around(int lo, int hi, int level, bool tiled, int from, int to) {
    const int boundary = (((lo + hi) >> level) + 1) >> 1;
    Pair pair{boundary - 1, boundary};
    if (tiled) {
      const int first = from >> level;
      const int last = (to - 1) >> level;
      pair.first = std::clamp(pair.first, first, std::max(last - 1, first));
      pair.last = std::min(pair.first + 1, last);
    }
    return pair;
  }

  PixelRect image_;
  int epsilon_px_;
  int tile_px_;
  AlphaQuadtree tree_;
};

}  // namespace

std::unique_ptr<Visibility> makeQuadtreeVisibility(int width, int height, int epsilon_px, int tile_px) {
  return std::make_unique<QuadtreeVisibility>(width, height, epsilon_px, tile_px);
}

}  // namespace kiln
