// A tile of the picture, as the kernels of all lattices draw into it.
#pragma once

#include <cstddef>

#include "engine/shared/aov_pixels.h"
#include "image/deep_samples.h"
#include "image/pixel_rect.h"

namespace kiln {

/// The edge of what one thread draws of a tile at a time, at most: a row is a word. unit: pixels.
inline constexpr int kSquareEdge = 64;

/// The pixels of one tile. shape: `rgba` points at pixel (rect.x0, rect.y0), rows `stride` floats apart.
struct TilePixels {
  PixelRect rect;
  float* rgba = nullptr;
  std::ptrdiff_t stride = 0;
  AovPixels aovs;
  DeepSamples* deep = nullptr;  // of the whole picture's pixels; null where nobody asked

  /// Of pixel (x, y), counted from the first one. requires: in `rect`.
  std::ptrdiff_t placeOf(int x, int y) const { return (y - rect.y0) * (stride / 4) + (x - rect.x0); }
  /// Those of `part` alone. requires: inside of `rect`.
  TilePixels of(const PixelRect& part) const {
    const std::ptrdiff_t first = placeOf(part.x0, part.y0);
    return {part, rgba + 4 * first, stride, aovs.from(first), deep};
  }
};

}  // namespace kiln
