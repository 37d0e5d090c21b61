// The curve between linear light, in which Kiln computes, and sRGB, in which people name colours and displays show
// them. Source: IEC 61966-2-1: a line near black, a power above it.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace kiln {

/// One channel in [0, 1], decoded and encoded.
inline double linearFromSrgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
inline double srgbFromLinear(double linear) {
  return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

/// The byte of a picture of 8 bits, which is asked for millions of times: round(255 · srgbFromLinear(v)), of what is
/// below 0 that of 0, above 1 that of 1, of NaN 0. cost: 2 ns; the curve's power takes 20 to 40.
class SrgbBytes {
 public:
  static const SrgbBytes& all();

  std::uint8_t of(double linear) const {
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 255;
    const std::uint8_t byte = at_cell_[static_cast<std::size_t>(linear * kCells)];
    return static_cast<std::uint8_t>(byte + (linear >= next_[byte] ? 1 : 0));
  }

 private:
  // A byte is nowhere shorter than a cell: near black there are 255 · 12.92 bytes to 1.
  static constexpr std::size_t kCells = 4096;

  SrgbBytes();

  std::array<std::uint8_t, kCells> at_cell_;  // at the beginning of each
  std::array<double, 256> next_;              // where the byte after each begins
};

}  // namespace kiln
