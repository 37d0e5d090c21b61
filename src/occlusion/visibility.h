// Image-space coherence.
// Problem. Bricks, cells and voxels behind opaque pixels need not be drawn.
// Method. One query: is a rectangle of pixels opaque? One update: a pixel became opaque. The implementations differ in
// cost and exactness, one file each.
// Source: Lee and Ihm §2.
#pragma once

#include <bit>
#include <cstdint>
#include <memory>

#include "image/pixel_rect.h"

namespace kiln {

/// The least edge of an image tile: calls for pixels of different tiles may run at the same time. unit: pixels.
inline constexpr int kVisibilityTile = 64;
/// Logarithm of kVisibilityTile. Threads share squares and segments above this level.
inline constexpr int kVisibilityTileLevel = std::countr_zero(static_cast<unsigned>(kVisibilityTile));

class Visibility {
 public:
  virtual ~Visibility() = default;
  /// True if every pixel of `rect` inside the image is opaque. An exact method returns true only in this case; the
  /// quadtree with approximate areas may return true for a visible rectangle. thread: safe against `close` in tiles
  /// that `rect` does not touch.
  virtual bool hidden(const PixelRect& rect) const = 0;
  /// Marks pixel (x, y) as opaque. requires: inside the image, and not closed before.
  virtual void close(int x, int y) = 0;
};

/// Hides nothing: Lee and Ihm's baseline, octree only.
std::unique_ptr<Visibility> makeNoVisibility();
/// The 64-bit mask: exact. unit: pixels.
std::unique_ptr<Visibility> makeMaskVisibility(int width, int height);
/// Returns the memory of a mask. unit: bytes.
std::uint64_t maskBytes(int width, int height);
/// The alpha range tree: exact. cost: about 4 bytes a pixel of the image padded to powers of two.
std::unique_ptr<Visibility> makeRangeTreeVisibility(int width, int height);
/// Returns the memory of a range tree. unit: bytes.
std::uint64_t rangeTreeBytes(int width, int height);
/// The alpha quadtree with Meagher's overlays: exact, but finds fewer hidden rectangles. A rectangle inside a tile of
/// `tile_px` pixels is tested by squares of this tile. requires: tile_px a power of two of at least kVisibilityTile, or
/// 0 (no tiles).
std::unique_ptr<Visibility> makeOverlayVisibility(int width, int height, int tile_px = 0);
/// The alpha quadtree with approximate projected areas: may report a visible rectangle as hidden. A rectangle is
/// enlarged by `epsilon_px` on every side before the test. requires: tile_px as for overlays, epsilon_px >= 0.
std::unique_ptr<Visibility> makeQuadtreeVisibility(int width, int height, int epsilon_px = 0, int tile_px = 0);
/// Returns the memory of a quadtree, also with overlays. unit: bytes.
std::uint64_t quadtreeBytes(int width, int height);

}  // namespace kiln
