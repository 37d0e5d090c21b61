// A tile as the kernel of the voxel lattice draws into it: channel by channel, so that eight pixels of a row are a
// vector of each channel. Invariant: pixels beside the tile, kBeside on either side of a row, are closed, so that a
// footprint that reaches over its edge needs no other code and changes nothing there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/shared/tile_pixels.h"
#include "engine/voxel/project_voxels.h"

namespace kiln {

class TilePlanes {
 public:
  /// Pixels that are read and written at a time, whichever of them a footprint has.
  static constexpr int kWide = 8;
  static constexpr int kBeside = kWide;

  /// Has room for any part of a tile of this size, and for no more than the largest asked for. throws: std::bad_alloc.
  void reserve(const PixelRect& tile);
  /// Holds the pixels of `tile` from now on, which nobody else may draw into. requires: room for it.
  void take(const TilePixels& tile) noexcept;
  /// Puts them back where they are from.
  void putBack() const;

  /// Bits of those voxels of `asked` that have an open pixel in the tile: what an exact method of visibility would say.
  /// requires: all of them touch the tile.
  std::uint32_t open(const ProjectedVoxels& voxels, std::uint32_t asked) const;

  const PixelRect& rect() const { return tile_.rect; }
  const AovPixels& aovs() const { return tile_.aovs; }
  std::ptrdiff_t placeOf(int x, int y) const { return tile_.placeOf(x, y); }
  /// Red of a pixel; green, blue and alpha are `plane` floats apart, rows four times as many. requires: y in the tile,
  /// x at most kBeside to the left of it and kBeside - kWide beyond its end, where eight pixels from there on are used.
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
