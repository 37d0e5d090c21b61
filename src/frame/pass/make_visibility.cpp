#include "frame/pass/make_visibility.h"

#include <algorithm>
#include <utility>

namespace kiln {
namespace {

// Shifts coordinates: (x, y) of the frame is (0, 0) of the structure.
class VisibilityOfRect final : public Visibility {
 public:
  VisibilityOfRect(int x, int y, std::unique_ptr<Visibility> inside) : x_(x), y_(y), inside_(std::move(inside)) {}

  bool hidden(const PixelRect& rect) const override {
    return inside_->hidden({rect.x0 - x_, rect.y0 - y_, rect.x1 - x_, rect.y1 - y_});
  }
  void close(int x, int y) override { inside_->close(x - x_, y - y_); }

 private:
  const int x_, y_;
  const std::unique_ptr<Visibility> inside_;
};

}  // namespace

std::unique_ptr<Visibility> makeVisibilityOf(const PixelRect& rect, const VisibilityOptions& options, int tile_px) {
  // Tiles start at the frame's tiles.
  const int tile = std::max(tile_px, kVisibilityTile), x = rect.x0 / tile * tile, y = rect.y0 / tile * tile;
  std::unique_ptr<Visibility> inside = makeVisibility(options, {rect.x1 - x, rect.y1 - y}, tile_px);
  if (x == 0 && y == 0) return inside;
  return std::make_unique<VisibilityOfRect>(x, y, std::move(inside));
}

std::unique_ptr<Visibility> makeVisibility(const VisibilityOptions& options, const ImageSize& size, int tile_px) {
  switch (options.method) {
    case VisibilityMethod::kMask:
      return makeMaskVisibility(size.width, size.height);
    case VisibilityMethod::kRangeTree:
      return makeRangeTreeVisibility(size.width, size.height);
    case VisibilityMethod::kQuadtree:
      return makeQuadtreeVisibility(size.width, size.height, options.epsilon_px, tile_px);
    case VisibilityMethod::kOverlay:
      return makeOverlayVisibility(size.width, size.height, tile_px);
    case VisibilityMethod::kNone:
      break;
  }
  return makeNoVisibility();
}

std::uint64_t visibilityBytes(VisibilityMethod method, const ImageSize& size) {
  switch (method) {
    case VisibilityMethod::kMask:
      return maskBytes(size.width, size.height);
    case VisibilityMethod::kRangeTree:
      return rangeTreeBytes(size.width, size.height);
    case VisibilityMethod::kQuadtree:
    case VisibilityMethod::kOverlay:
      return quadtreeBytes(size.width, size.height);
    case VisibilityMethod::kNone:
      break;
  }
  return 0;
}

}  // namespace kiln
