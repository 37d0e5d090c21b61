// Converts between linear light, used in all computations, and sRGB, used for named colours and displays.
// Source: IEC 61966-2-1: a line near black, a power law above.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

namespace kiln {

/// Decode and encode one channel in [0, 1].
inline double linearFromSrgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
inline glm::dvec3 linearFromSrgb(const glm::dvec3& encoded) {
  return {linearFromSrgb(encoded.r), linearFromSrgb(encoded.g), linearFromSrgb(encoded.b)};
}
inline double srgbFromLinear(double linear) {
  return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

/// Table for 8-bit pictures: round(255 · srgbFromLinear(v)). Values below 0 and NaN give 0, values above 1 give 255.
/// cost: 2 ns instead of 20 to 40 ns for the power.
class SrgbBytes {
 public:
  static const SrgbBytes& all();

  std::uint8_t of(double linear) const {
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 255;
    const std::uint8_t byte = at_cell_[static_cast<std::size_t>(linear * kCells)];
    return static_cast<std::uint8_t>(byte + (linear >= next_[byte] ? 1 : 0));
  }

  /// Returns the byte below or above the light: above where its fraction of a byte and `threshold` are at least 1. The
  /// mean over thresholds from 0 to 1 is the light's place between the bytes.
  std::uint8_t dithered(double linear, double threshold) const {
    std::uint8_t below = of(linear);
    if (!(linear > 0) || linear >= 1) return below;
    if (linear < light_[below]) --below;
    const double fraction = (linear - light_[below]) * bytes_per_light_[below];
    return static_cast<std::uint8_t>(below + (fraction + threshold >= 1 ? 1 : 0));
  }

 private:
  // A cell is never longer than the interval of a byte: near black there are 255 · 12.92 bytes per unit.
  static constexpr std::size_t kCells = 4096;

  SrgbBytes();

  std::array<std::uint8_t, kCells> at_cell_;  // the byte at the start of each cell
  std::array<double, 256> next_;              // the start of the byte after each byte
  std::array<double, 256> light_;             // the light of each byte
  std::array<double, 255> bytes_per_light_;   // between a byte's light and the next byte's
};

}  // namespace kiln
