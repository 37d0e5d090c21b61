// Voxels as halves, many at once: which do their bits make, and does every one of them survive it? Voxels of 8 and 16
// bits by table. Internal, and not installed.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "grid/openvdb_glue.h"

namespace kiln {

inline std::uint16_t halfBitsOf(float value) { return openvdb::math::half(value).bits(); }

/// Of all values of 16 bits, by their bits.
template <class T>
struct HalfTable {
  std::array<std::uint16_t, 65536> bits;
  std::array<bool, 65536> survives;
  HalfTable() {
    for (std::size_t i = 0; i < bits.size(); ++i) {
      const auto value = static_cast<float>(static_cast<T>(i));
      bits[i] = halfBitsOf(value);
      survives[i] = survivesHalf(value);
    }
  }
};
template <class T>
const HalfTable<T>& halfTable() {
  static const auto table = std::make_unique<const HalfTable<T>>();
  return *table;
}

/// A function from values to the bits of their halves. cost: once, not a value.
template <class T>
auto toHalfBits() {
  if constexpr (std::is_integral_v<T> && sizeof(T) <= 2) {
    return [bits = halfTable<T>().bits.data()](T value) { return bits[static_cast<std::uint16_t>(value)]; };
  } else {
    return [](T value) { return halfBitsOf(static_cast<float>(value)); };
  }
}

/// Whether every value comes back bit for bit from a half.
template <class T>
bool fitHalf(std::span<const T> values) {
  if constexpr (std::is_same_v<T, float>) {
    for (std::size_t first = 0; first < values.size(); first += 1024) {
      const std::span<const float> some = values.subspan(first, std::min<std::size_t>(1024, values.size() - first));
      // A half has 10 bits behind the point and 5 of exponent: most values are told by their bits.
      std::uint32_t others = 0;
      for (const float value : some) {
        const auto bits = std::bit_cast<std::uint32_t>(value), size = bits & 0x7fffffffu;
        const bool normal = size >= 0x38800000u && size <= 0x477fe000u;
        others += (bits & 0x1fffu) != 0 || !(normal || size == 0);
      }
      if (others != 0 && !std::all_of(some.begin(), some.end(), survivesHalf)) return false;
    }
    return true;
  } else if constexpr (sizeof(T) == 1) {
    return true;
  } else if constexpr (std::is_integral_v<T> && sizeof(T) == 2) {
    T lo = std::numeric_limits<T>::max(), hi = std::numeric_limits<T>::min();
    for (const T value : values) lo = std::min(lo, value), hi = std::max(hi, value);
    if (lo >= -2048 && hi <= 2048) return true;
    const auto& survives = halfTable<T>().survives;
    return std::all_of(values.begin(), values.end(),
                       [&](T value) { return survives[static_cast<std::uint16_t>(value)]; });
  } else {
    return false;
  }
}

}  // namespace kiln
