// A block of a sheet laid behind what the image holds: the pixels of a slab composited, a vector of them at a time. One
// implementation in Highway for every instruction set, as in splat/refine_unit.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "splat/coverage.h"
#include "splat/tile_windows.h"

namespace kiln {

/// One bit a pixel. shape: bit x of word y.
using BlockBits = std::array<std::uint8_t, kBlockEdge>;

struct SheetBlock {
  float* pixels = nullptr;         // of the image: premultiplied RGBA. shape: rows `stride` floats apart
  std::int32_t* sums = nullptr;    // of the sheet: RGBA. shape: rows `columns` pixels apart
  std::int32_t* filled = nullptr;  // the same, one a pixel
  std::ptrdiff_t stride = 0, columns = 0;
  CoveredPixel* covered = nullptr;  // of the image. shape: rows stride / 4 apart
  float erosion = 0;                // of pixels at edges, at most
  float color_unit = 1;             // of the sheet
  int width = 0, height = 0;        // at most kBlockEdge
  BlockBits takes{};                // the pixels that take light from the slab
  float opaque_at = 1;
};

/// What became of its pixels.
struct LaidBlock {
  BlockBits changed{};
  BlockBits opaque{};  // those of them whose alpha has reached `opaque_at`
};

/// A pixel that changed: its alpha before, what the sums were multiplied by, and two of the sums.
struct LaidPixel {
  float before = 0, share = 0, opacity = 0, filled = 0;
};
/// shape: rows of kBlockEdge.
struct LaidPixels {
  std::array<LaidPixel, kBlockEdge * kBlockEdge> pixels;
  /// Of each, what the slab adds where nothing is in front of it, but for what it covers of the pixel; and that.
  struct Slab {
    float rgb[3], part;
  };
  std::array<Slab, kBlockEdge * kBlockEdge> slabs;
};

/// Adds the light of the slab to the pixels, and empties the block of the sheet, kBlockEdge pixels wide. `pixels` may
/// be null; of those that do not change it holds anything.
LaidBlock laySheet(const SheetBlock& block, LaidPixels* pixels);

}  // namespace kiln
