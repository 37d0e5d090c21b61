// A row of a picture as a display shows it: straight sRGB, dithered.
#pragma once

#include <array>
#include <cstdint>

#include "image/image.h"

namespace kiln {

/// Position of a file's first pixel in the pattern of dithering. Views side by side have the pattern of a view each.
struct PatternPlace {
  int x = 0, y = 0;
  int views = 1;  // of equal width, in the file
};

/// Converts a pixel of linear premultiplied light to straight sRGB and alpha of 16 bits. NaN becomes 0.
std::array<std::uint16_t, 4> shownPixel16(const float* rgba) noexcept;

/// Converts row `y` of linear premultiplied light, row `file_y` of the file, to straight sRGB. shape: 4 samples of
/// `bits` (8 or 16) per pixel, big-endian. NaN becomes 0.
void encodeShownRow(const Image& image, int y, int file_y, const PatternPlace& place, int bits,
                    std::uint8_t* out) noexcept;

}  // namespace kiln
