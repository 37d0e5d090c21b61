// Image-space coherence: one question, whether a rectangle of pixels is already opaque, and one update, that a pixel
// has become so. The answers differ in price and exactness, one file each. Source: Lee and Ihm §2.
#pragma once

#include <bit>
#include <memory>

#include "image/pixel_rect.h"

namespace kiln {

/// The least edge of an image tile, in pixels: calls for pixels of different tiles may run at the same time.
inline constexpr int kVisibilityTile = 64;
/// Its logarithm: squares and segments of higher levels than this are shared by threads.
inline constexpr int kVisibilityTileLevel = std::countr_zero(static_cast<unsigned>(kVisibilityTile));

class Visibility {
 public:
  virtual ~Visibility() = default;
  /// Whether every pixel of `rect` that is in the image is opaque. An exact method says so only where it is true.
  /// thread: safe against `close` in tiles that `rect` does not touch.
  virtual bool hidden(const PixelRect& rect) const = 0;
  /// Pixel (x, y) has become opaque. requires: in the image, and not closed before.
  virtual void close(int x, int y) = 0;
};

/// Knows nothing: octree only, the baseline of Lee and Ihm.
std::unique_ptr<Visibility> makeNoVisibility();
/// The 64-bit mask: exact. unit: pixels.
std::unique_ptr<Visibility> makeMaskVisibility(int width, int height);
/// The alpha range tree: exact. cost: about 4 bytes a pixel of the image padded to powers of two.
std::unique_ptr<Visibility> makeRangeTreeVisibility(int width, int height);
/// The alpha quadtree with Meagher's overlays: exact, and loose. A rectangle inside one tile of `tile_px` pixels is
/// judged by squares of that tile. requires: tile_px a power of two of at least kVisibilityTile, or 0: no tiles.
std::unique_ptr<Visibility> makeOverlayVisibility(int width, int height, int tile_px = 0);
/// The alpha quadtree with approximate projected areas: may call hidden what is not. A rectangle is enlarged by
/// `epsilon_px` on every side before it is approximated. requires: tile_px as above, epsilon_px >= 0.
std::unique_ptr<Visibility> makeQuadtreeVisibility(int width, int height, int epsilon_px = 0, int tile_px = 0);

}  // namespace kiln
