// The curve between linear light, in which Kiln computes, and sRGB, in which people name colours and displays show
// them. Source: IEC 61966-2-1: a line near black, a power above it.
#pragma once

#include <cmath>

namespace kiln {

/// One channel in [0, 1], decoded and encoded.
inline double linearFromSrgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
inline double srgbFromLinear(double linear) {
  return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

}  // namespace kiln
