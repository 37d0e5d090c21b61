#include "frame/make_visibility.h"

namespace kiln {

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

}  // namespace kiln
