// From the bytes of a file to the values that they mean: another byte order, and a linear map to another type.
#pragma once

#include "grid/voxel_type.h"

namespace kiln {

/// Reverses the bytes of each of `count` values of `size` bytes.
void swapBytes(std::byte* data, std::size_t count, std::size_t size) noexcept;

/// value = stored * slope + intercept, in double, rounded once to `to`; an integer saturates, and NaN becomes 0 there.
struct ValueMap {
  VoxelType from, to;
  /// Whether the file's byte order is not the machine's.
  bool swap = false;
  double slope = 1, intercept = 0;

  /// Whether a stored value may become infinite as a 32-bit float, or the factor 0. Stored floats are taken to be at
  /// most 1e8, as instruments measure.
  bool leavesFloat() const;
  /// Whether neighbours of 16 stored bits may become one 32-bit float, as with a large offset.
  bool mergesInFloat() const;
  /// The bytes are the values, but for their order.
  bool copies() const { return from == to && slope == 1 && intercept == 0; }
  /// Brings `count` stored values into the machine's order, in place.
  void order(std::byte* data, std::size_t count) const noexcept {
    if (swap && sizeOf(from) > 1) swapBytes(data, count, sizeOf(from));
  }
  /// Maps `count` values in the machine's order. requires: `out` does not overlap `in`.
  void apply(const std::byte* in, std::size_t count, std::byte* out) const noexcept;
};

}  // namespace kiln
