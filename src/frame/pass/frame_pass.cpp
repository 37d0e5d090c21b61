#include "frame/pass/frame_pass.h"

namespace kiln {

std::vector<PixelRect> tilesOf(int tile_px, const PixelRect& drawn, const PixelRect& rect) {
  const int edge = tile_px;
  if (edge == 0) return {drawn};
  std::vector<PixelRect> out;
  for (int y = rect.y0 / edge * edge; y < rect.y1; y += edge) {
    for (int x = rect.x0 / edge * edge; x < rect.x1; x += edge)
      out.push_back(intersection(PixelRect{x, y, x + edge, y + edge}, drawn));
  }
  return out;
}

}  // namespace kiln
