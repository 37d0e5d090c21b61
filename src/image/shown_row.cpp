#include "image/shown_row.h"

#include <algorithm>

#include "image/dither.h"
#include "image/srgb.h"

namespace kiln {
namespace {

double alphaOf(const float* rgba) { return rgba[3] > 0 ? std::min<double>(rgba[3], 1) : 0; }

}  // namespace

std::array<std::uint16_t, 4> shownPixel16(const float* rgba) noexcept {
  const auto sample = [](double v) { return static_cast<std::uint16_t>(v * 65535 + 0.5); };
  const double alpha = alphaOf(rgba);
  std::array<std::uint16_t, 4> out;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const double straight = alpha > 0 ? rgba[channel] / alpha : 0;
    out[channel] = sample(straight > 0 ? srgbFromLinear(std::min(straight, 1.0)) : 0);
  }
  out[3] = sample(alpha);
  return out;
}

void encodeShownRow(const Image& image, int y, int file_y, const PatternPlace& place, int bits,
                    std::uint8_t* out) noexcept {
  const SrgbBytes& bytes = SrgbBytes::all();
  // All channels of a pixel have one threshold, so that grey stays grey.
  const DitherRow dither(place.y + file_y);
  const int view_width = image.width / place.views;
  for (int x = 0; x < image.width; ++x) {
    const float* const rgba = image.pixel(x, y);
    if (bits == 16) {
      for (const std::uint16_t sample : shownPixel16(rgba)) {
        *out++ = static_cast<std::uint8_t>(sample >> 8);
        *out++ = static_cast<std::uint8_t>(sample & 255);
      }
      continue;
    }
    const double threshold = dither.at(place.x + x % view_width), alpha = alphaOf(rgba);
    for (int channel = 0; channel < 3; ++channel)
      *out++ = bytes.dithered(alpha > 0 ? rgba[channel] / alpha : 0, threshold);
    *out++ = static_cast<std::uint8_t>(alpha * 255 + 0.5);
  }
}

}  // namespace kiln
