// Blosc's frame around the values of a leaf, as brick_archive.cpp has Blosc make it: one block of LZ4, its bytes
// shuffled by fours, or the values as they are where that is no smaller. Blosc's own reader has memory given to it for
// each frame, which takes as long as all else it does, and puts bytes together that a voxel of fewer does not need.
// Internal, and not installed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "base/vectors.h"
#include "store/codec/brick_file.h"

namespace kiln {

/// Numbers are shuffled as so many bytes each, whatever their type.
inline constexpr std::size_t kBloscTypeBytes = 4;

/// Whether it is such a frame of so many bytes of values, and these a multiple of kBloscTypeBytes.
bool isLeafFrame(std::span<const std::byte> frame, std::size_t bytes) noexcept;

/// The values of such a frame where they are as they were; null where they are packed.
const std::byte* keptValues(std::span<const std::byte> frame) noexcept;

/// Unpacks the first `wanted` bytes of `bytes` where they are packed: the first byte of each four, then all second
/// ones, and so on. False where it is damaged. shape: `planes` has `bytes`.
bool unpackPlanes(std::span<const std::byte> frame, std::size_t bytes, std::size_t wanted,
                  std::uint8_t* planes) noexcept;

/// The numbers of those bytes: `count` of type Stored, of which a T of fewer bytes is the lower ones. requires: Stored
/// is a T, or a whole number of four bytes; count · sizeof(Stored) a multiple of four.
template <class Stored, class T>
KILN_VECTORS void joinPlanes(const std::uint8_t* __restrict planes, std::size_t count, T* __restrict out) noexcept {
  if constexpr (sizeof(T) < sizeof(Stored)) {
    static_assert(sizeof(Stored) == kBloscTypeBytes && sizeof(T) <= 2);
    if constexpr (sizeof(T) == 1) {
      std::memcpy(out, planes, count);
    } else {
      for (std::size_t i = 0; i < count; ++i) out[i] = static_cast<T>(planes[i] | planes[count + i] << 8);
    }
  } else {
    const std::size_t n = count * sizeof(T) / kBloscTypeBytes;
    auto* const to = reinterpret_cast<std::byte*>(out);
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t four = planes[i] | std::uint32_t{planes[n + i]} << 8 |
                                 std::uint32_t{planes[2 * n + i]} << 16 | std::uint32_t{planes[3 * n + i]} << 24;
      std::memcpy(to + kBloscTypeBytes * i, &four, sizeof four);
    }
  }
}

/// What of a leaf's value a voxel of type T has: those of fewer than four bytes are kept as Int32, and need no others.
template <class Stored, class T>
using UnpackedFor = std::conditional_t<std::is_same_v<Stored, std::int32_t> && sizeof(T) < kBloscTypeBytes, T, Stored>;

/// The `count` values of a leaf, of which the frame has them as Stored. False where it is damaged. requires:
/// isLeafFrame; T as UnpackedFor has it.
template <class Stored, class T>
bool unpackLeaf(std::span<const std::byte> frame, std::size_t count, T* out) noexcept {
  if (const std::byte* const kept = keptValues(frame)) {
    for (std::size_t i = 0; i < count; ++i) {
      Stored value;
      std::memcpy(&value, kept + i * sizeof value, sizeof value);
      out[i] = static_cast<T>(value);
    }
    return true;
  }
  alignas(64) std::uint8_t planes[kLeaf * kLeaf * kLeaf * sizeof(Stored)];
  if (!unpackPlanes(frame, count * sizeof(Stored), count * sizeof(T), planes)) return false;
  joinPlanes<Stored>(planes, count, out);
  return true;
}

}  // namespace kiln
