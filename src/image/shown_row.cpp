#include "image/shown_row.h"

#include <algorithm>

#include "image/dither.h"
#include "image/srgb.h"

namespace kiln {
namespace {

// Writes a big-endian 16-bit sample and returns the position behind the sample.
std::uint8_t* putSixteen(double v, std::uint8_t* out) noexcept {
  const auto sample = static_cast<unsigned>(v * 65535 + 0.5);
  *out++ = static_cast<std::uint8_t>(sample >> 8);
  *out++ = static_cast<std::uint8_t>(sample & 255);
  return out;
}

}  // namespace

void encodeShownRow(const Image& image, int y, int file_y, const PatternPlace& place, int bits,
                    std::uint8_t* out) noexcept {
  const SrgbBytes& bytes = SrgbBytes::all();
  // All channels of a pixel have one threshold, so that grey stays grey.
  const DitherRow dither(place.y + file_y);
  const int view_width = image.width / place.views;
  for (int x = 0; x < image.width; ++x) {
    const double threshold = dither.at(place.x + x % view_width);
    const float* const rgba = image.pixel(x, y);
    const double alpha = rgba[3] > 0 ? std::min<double>(rgba[3], 1) : 0;
    for (int channel = 0; channel < 3; ++channel) {
      const double straight = alpha > 0 ? rgba[channel] / alpha : 0;
      if (bits == 8)
        *out++ = bytes.dithered(straight, threshold);
      else
        out = putSixteen(straight > 0 ? srgbFromLinear(std::min(straight, 1.0)) : 0, out);
    }
    if (bits == 8)
      *out++ = static_cast<std::uint8_t>(alpha * 255 + 0.5);
    else
      out = putSixteen(alpha, out);
  }
}

}  // namespace kiln
