// A tile of the picture as all engines draw it.
#pragma once

#include <cstddef>

#include "engine/shared/aov_pixels.h"
#include "engine/shared/deep_shadow_map.h"
#include "engine/shared/extinction_lattice.h"
#include "image/deep_samples.h"
#include "image/pixel_rect.h"

namespace kiln {

/// Largest edge of the square that a thread draws at a time: a row of pixels fits a 64-bit word. unit: pixels.
inline constexpr int kSquareEdge = 64;

/// Calls f(square) for squares that fill `rect`, of at most kSquareEdge pixels an edge.
template <class F>
void forEachSquare(const PixelRect& rect, const F& f) {
  for (int y = rect.y0; y < rect.y1; y += kSquareEdge) {
    for (int x = rect.x0; x < rect.x1; x += kSquareEdge)
      f(intersection(PixelRect{x, y, x + kSquareEdge, y + kSquareEdge}, rect));
  }
}

/// Pixels of one tile. shape: `rgba` points to pixel (rect.x0, rect.y0), rows are `stride` floats apart.
struct TilePixels {
  PixelRect rect;
  float* rgba = nullptr;
  std::ptrdiff_t stride = 0;
  AovPixels aovs;
  DeepSamples* deep = nullptr;              // samples of the whole picture's pixels; null if not requested
  DeepShadowMap* shadows = nullptr;         // the map of a light whose view is drawn; samples are then not lit
  ExtinctionLattice* extinction = nullptr;  // drawn instead of pixels, by the engine of several volumes

  /// Index of pixel (x, y), counted from the tile's first pixel. requires: (x, y) in `rect`.
  std::ptrdiff_t placeOf(int x, int y) const { return (y - rect.y0) * (stride / 4) + (x - rect.x0); }
  /// Returns the tile restricted to `part`. requires: `part` inside `rect`.
  TilePixels of(const PixelRect& part) const {
    const std::ptrdiff_t first = placeOf(part.x0, part.y0);
    return {part, rgba + 4 * first, stride, aovs.from(first), deep, shadows, extinction};
  }
};

}  // namespace kiln
