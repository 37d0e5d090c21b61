// Problem. The test of a rectangle in O(1), never wrong for a visible rectangle.
// Method. Four adjacent standard squares enclose the rectangle: those of the least edge not below the rectangle's,
// starting at the square of the first pixel. The rectangle is hidden if all four are opaque.
// Invariant. Exact, because the squares enclose the rectangle. The test may miss a hidden rectangle, because the
// squares cover up to sixteen times its area.
// Source: Meagher 1982, as in Lee and Ihm §2.3.3, Figure 5 and Table 5.
// Differs only for tiles drawn in parallel: squares outside the tile contain nothing of the rectangle and are not
// tested.
// Cost: O(1).
#include <bit>

#include "occlusion/alpha_quadtree.h"

namespace kiln {
namespace {

class OverlayVisibility final : public Visibility {
 public:
  OverlayVisibility(int width, int height, int tile_px)
      : image_{0, 0, width, height}, tile_px_(tile_px), tree_(width, height) {}

  bool hidden(const PixelRect& wanted) const override {
    const PixelRect rect = intersection(wanted, image_);
    if (rect.empty()) return true;
    const auto edge = static_cast<unsigned>(std::max(rect.x1 - rect.x0, rect.y1 - rect.y0));
    const int level = std::min(static_cast<int>(std::bit_width(edge - 1)), tree_.top());
    const SquareBounds bounds = squareBoundsOf(rect, tile_px_, image_);
    const int last_x = std::min((rect.x0 >> level) + 1, (bounds.pixels.x1 - 1) >> level);
    const int last_y = std::min((rect.y0 >> level) + 1, (bounds.pixels.y1 - 1) >> level);
    for (int y = rect.y0 >> level; y <= last_y; ++y) {
      for (int x = rect.x0 >> level; x <= last_x; ++x) {
        if (!tree_.opaque(level, x, y)) return false;
      }
    }
    return true;
  }

  void close(int x, int y) override { tree_.close(x, y); }

 private:
  PixelRect image_;
  int tile_px_;
  AlphaQuadtree tree_;
};

}  // namespace

std::unique_ptr<Visibility> makeOverlayVisibility(int width, int height, int tile_px) {
  return std::make_unique<OverlayVisibility>(width, height, tile_px);
}

}  // namespace kiln
