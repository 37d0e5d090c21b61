// Turns the bytes of a file into values: swaps the byte order and applies a linear map to another type.
#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

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
  /// Memory of readMapped beside its output. unit: bytes.
  std::uint64_t pieceBytes() const { return copies() ? 0 : kPieceBytes; }
  /// Returns the first of `count` wide integers that does not fit its voxel type, as text; nothing if all fit, or
  /// become floats.
  std::optional<std::string> misfit(const std::byte* in, std::size_t count) const;
  /// Maps `count` values in the machine's byte order. requires: `out` does not overlap `in`.
  void apply(const std::byte* in, std::size_t count, std::byte* out) const noexcept;

  static constexpr std::size_t kPieceBytes = 1 << 20;
};

/// throws: Error kFormat, with the slice, if one of `count` wide integers does not fit its voxel type.
void requireFits(const ValueMap& map, const std::byte* stored, std::size_t count, const std::filesystem::path& file,
                 std::int64_t slice);

/// Fills `out` with `count` values of one slice, whose stored bytes `read(piece)` returns piece by piece, in order.
/// throws: as requireFits; the exceptions of `read`. cost: `map.pieceBytes()`.
template <class Read>
void readMapped(const ValueMap& map, std::uint64_t count, std::byte* out, const std::filesystem::path& file,
                std::int64_t slice, Read&& read) {
  const std::size_t size = sizeOf(map.from), all = static_cast<std::size_t>(count);
  if (map.copies()) {
    read(std::span(out, all * size));
    map.order(out, all);
    return;
  }
  std::vector<std::byte> stored(std::min(all * size, ValueMap::kPieceBytes));
  for (std::size_t done = 0; done < all;) {
    const std::size_t now = std::min(all - done, stored.size() / size);
    read(std::span(stored).first(now * size));
    map.order(stored.data(), now);
    requireFits(map, stored.data(), now, file, slice);
    map.apply(stored.data(), now, out + done * sizeOf(map.to));
    done += now;
  }
}

}  // namespace kiln
