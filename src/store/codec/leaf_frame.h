// Reads Blosc's frame around the values of a leaf, as written by brick_archive.cpp: one LZ4 block with bytes shuffled
// by fours, or uncompressed values if LZ4 saves nothing.
// Problem. Blosc's reader allocates memory per frame, which takes as long as all its further work, and joins bytes that
// a voxel of fewer bytes does not need.
// Internal, not installed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "base/vectors.h"
#include "store/codec/brick_file.h"

namespace kiln {

/// Size of a number in Blosc's shuffle, for every type. unit: bytes.
inline constexpr std::size_t kBloscTypeBytes = 4;

/// True for such a frame around `bytes` bytes of values, a multiple of kBloscTypeBytes.
bool isLeafFrame(std::span<const std::byte> frame, std::size_t bytes) noexcept;

/// Returns the values of an uncompressed frame; null for a compressed frame.
const std::byte* keptValues(std::span<const std::byte> frame) noexcept;

/// Decompresses the first `wanted` of `bytes` bytes of a compressed frame: the first byte of each number, then the
/// second bytes, and so on. Returns false if the frame is damaged. shape: `planes` has `bytes` bytes.
bool unpackPlanes(std::span<const std::byte> frame, std::size_t bytes, std::size_t wanted,
                  std::uint8_t* planes) noexcept;

/// Joins the byte planes to `count` numbers of type Stored; a smaller T receives the lower bytes. requires: Stored is
/// T, or Stored has four bytes and T fewer; count · sizeof(Stored) is a multiple of four.
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

/// The type in which values are unpacked: voxels of one or two bytes are stored as Int32, of which only the lower bytes
/// are needed.
template <class Stored, class T>
using UnpackedFor = std::conditional_t<std::is_same_v<Stored, std::int32_t> && sizeof(T) < kBloscTypeBytes, T, Stored>;

/// Unpacks the `count` values of a leaf from a frame of Stored values. Returns false if the frame is damaged. requires:
/// isLeafFrame; T is UnpackedFor<Stored, voxel type>.
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
