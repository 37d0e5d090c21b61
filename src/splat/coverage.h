// What of a pixel's area slabs cover. Samples at an edge fill a pixel a little in every slab that they reach. Laid one
// behind the other as if they had nothing to do with each other, these parts would close the pixel, half a pixel beyond
// the edge. But a body's cross-sections lie behind each other: what a slab covers is taken to contain, or to be a part
// of, what those in front of it do (splat/lay_sheet.cpp).
#pragma once

#include <cstdint>

namespace kiln {

/// What slabs cover of a pixel so far, rounded up. unit: 255ths of its area.
using CoveredPixel = std::uint8_t;

/// How much of a slab counts as a solid's, its samples of `opacity`, and not as a thin medium's: what four such slabs
/// hide.
inline float solidOf(float opacity) {
  const float two_slabs = (1 - opacity) * (1 - opacity);
  return 1 - two_slabs * two_slabs;
}

/// How much less than one half of a pixel a slab covers that is filled to one half, its samples of `opacity`: not at
/// all where that is thin, so that what is split over two slabs keeps its sum; up to `most` where a few such slabs are
/// opaque.
inline float erosionOf(float opacity, float most) { return most * solidOf(opacity); }

/// What a slab is filled that covers half a pixel.
inline float fillingOfHalf(float erosion) { return 1 - 0.5f / (1 + erosion); }

}  // namespace kiln
