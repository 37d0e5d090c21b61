// Turns the bytes of a file into values: swaps the byte order and applies a linear map to another type.
#pragma once

#include <optional>
#include <string>

#include "ingest/bytes/stored_type.h"

namespace kiln {

/// Reverses the bytes of each of `count` values of `size` bytes.
void swapBytes(std::byte* data, std::size_t count, std::size_t size) noexcept;

/// value = stored * slope + intercept, in double, rounded once to `to`. Integers saturate, and NaN becomes 0 in
/// integers.
struct ValueMap {
  StoredType from;
  VoxelType to;
  /// True if the file's byte order differs from the machine's.
  bool swap = false;
  double slope = 1, intercept = 0;

  /// True if a stored value may become infinite as a 32-bit float, or the factor becomes 0. Stored floats are
  /// assumed to be at most 1e8, as instruments measure.
  bool leavesFloat() const;
  /// True if neighbouring 16-bit stored values may become equal as 32-bit floats, for example with a large offset.
  bool mergesInFloat() const;
  /// True if stored bytes and values are equal, except for the byte order.
  bool copies() const { return from.isVoxel() && from.voxel() == to && slope == 1 && intercept == 0; }
  /// Converts `count` stored values to the machine's byte order, in place.
  void order(std::byte* data, std::size_t count) const noexcept {
    if (swap && sizeOf(from) > 1) swapBytes(data, count, sizeOf(from));
  }
  /// Returns the first of `count` wide integers that does not fit its voxel type, as text; nothing if all fit.
  std::optional<std::string> misfit(const std::byte* in, std::size_t count) const;
  /// Maps `count` values in the machine's byte order. requires: `out` does not overlap `in`.
  void apply(const std::byte* in, std::size_t count, std::byte* out) const noexcept;
};

}  // namespace kiln
