// Conversion between floats and the bits of halves, and a fast test of whether all values of a list survive as halves.
// Internal, not installed.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>

#include "grid/openvdb_glue.h"

namespace kiln {

inline std::uint16_t halfBitsOf(float value) { return openvdb::math::half(value).bits(); }
inline float floatOfHalf(std::uint16_t bits) {
  openvdb::math::half value;
  value.setBits(bits);
  return value;
}

/// True if every value survives a round trip through half bit for bit.
inline bool fitHalf(std::span<const float> values) {
  for (std::size_t first = 0; first < values.size(); first += 1024) {
    const std::span<const float> some = values.subspan(first, std::min<std::size_t>(1024, values.size() - first));
    // A half has 10 mantissa bits and 5 exponent bits. A bit test decides for normal numbers and zero; only lists with
    // further values are converted.
    std::uint32_t others = 0;
    for (const float value : some) {
      const auto bits = std::bit_cast<std::uint32_t>(value), size = bits & 0x7fffffffu;
      const bool normal = size >= 0x38800000u && size <= 0x477fe000u;
      others += (bits & 0x1fffu) != 0 || !(normal || size == 0);
    }
    if (others != 0 && !std::all_of(some.begin(), some.end(), survivesHalf)) return false;
  }
  return true;
}

}  // namespace kiln
