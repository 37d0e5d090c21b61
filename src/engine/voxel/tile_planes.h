// Copy of a tile in planes, one per channel, for the voxel engine: eight pixels of a row are one vector per channel.
// Invariant. The kBeside pixels on either side of a row count as closed. A footprint that crosses the tile's edge needs
// no special code and changes nothing there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/shared/tile_pixels.h"
#include "engine/voxel/project_voxels.h"

namespace kiln {

class TilePlanes {
 public:
  /// Pixels of a row that are read and written together.
  static constexpr int kWide = 8;
  static constexpr int kBeside = kWide;

  /// Makes room for any part of a tile of this size. Memory is bounded by the largest requested tile. throws:
  /// std::bad_alloc.
  void reserve(const PixelRect& tile);
  /// Copies the pixels of `tile`; until putBack() no other code may draw into them. requires: room for the tile.
  void take(const TilePixels& tile) noexcept;
  /// Copies the planes back into the tile's pixels.
  void putBack() const;

  /// Returns a mask of the voxels of `asked` that have an open pixel in the tile; equals an exact visibility test.
  /// requires: every voxel of `asked` touches the tile.
  std::uint32_t open(const ProjectedVoxels& voxels, std::uint32_t asked) const;

  const PixelRect& rect() const { return tile_.rect; }
  const AovPixels& aovs() const { return tile_.aovs; }
  std::ptrdiff_t placeOf(int x, int y) const { return tile_.placeOf(x, y); }
  /// Red of pixel (x, y). Green, blue and alpha follow at distances of plane(); rows are 4 plane() apart. requires: y
  /// in the tile, x0 - kBeside <= x <= x1 + kBeside - kWide, as eight pixels from x on are accessed.
  float* at(int x, int y) { return values_.data() + offsetOf(x, y); }
  std::ptrdiff_t plane() const { return plane_; }
  /// unit: bytes.
  std::size_t bytes() const { return values_.capacity() * sizeof(float); }
  static std::size_t bytesFor(std::size_t width, std::size_t height) {
    return (width + 2 * kBeside) * 4 * height * sizeof(float);
  }

 private:
  std::ptrdiff_t offsetOf(int x, int y) const {
    return (y - tile_.rect.y0) * 4 * plane_ + (x - tile_.rect.x0) + kBeside;
  }

  TilePixels tile_;
  std::ptrdiff_t plane_ = 0;
  std::vector<float> values_;
};

}  // namespace kiln
