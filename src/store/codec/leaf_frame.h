// Reads and writes Blosc's frame around the values of a leaf: LZ4 blocks with bytes shuffled, or uncompressed values if
// LZ4 saves nothing. The brick writer makes one block with bytes shuffled by fours.
// Problem. Blosc allocates memory per frame, which takes as long as all its further work, and does not check the
// allocation: a thread without memory would end the process. Its reader joins bytes that a voxel of fewer bytes does
// not need.
// Invariant. The bytes of a frame equal those of Blosc at OpenVDB's level, without splitting.
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
/// A frame is at most this much larger than its values. unit: bytes.
inline constexpr std::size_t kFrameOverhead_bytes = 16;
/// The values of a leaf of the widest type. unit: bytes.
inline constexpr std::size_t kMostLeafBytes = kLeaf * kLeaf * kLeaf * sizeof(double);

/// Writes the frame around `bytes` bytes of values and returns its length. shape: `out` has room for `bytes` and the
/// overhead. requires: at most kMostLeafBytes.
std::size_t packLeaf(const void* values, std::size_t bytes, std::byte* out) noexcept;

/// True for a frame around `bytes` bytes of values, of any layout that Blosc gives LZ4 and bytes in shuffled order.
bool isLeafFrame(std::span<const std::byte> frame, std::size_t bytes) noexcept;
/// True for a frame of the brick writer, compressed or not. requires: isLeafFrame.
bool isPlainFrame(std::span<const std::byte> frame, std::size_t bytes) noexcept;

/// Returns the values of an uncompressed frame; null for a compressed frame.
const std::byte* keptValues(std::span<const std::byte> frame) noexcept;

/// Decompresses the first `wanted` of `bytes` bytes of a plain, compressed frame: the first byte of each number, then
/// the second bytes, and so on. Returns false if the frame is damaged. shape: `planes` has `bytes` bytes.
bool unpackPlanes(std::span<const std::byte> frame, std::size_t bytes, std::size_t wanted,
                  std::uint8_t* planes) noexcept;
/// Decompresses a compressed frame of any layout: several blocks, split blocks, numbers of another size. Returns false
/// if the frame is damaged. shape: `values` has `bytes` bytes. requires: isLeafFrame; at most kMostLeafBytes.
bool unpackBlocks(std::span<const std::byte> frame, std::size_t bytes, std::byte* values) noexcept;

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
/// isLeafFrame; T is UnpackedFor<Stored, voxel type>; at most the values of a leaf.
template <class Stored, class T>
bool unpackLeaf(std::span<const std::byte> frame, std::size_t count, T* out) noexcept {
  const std::size_t bytes = count * sizeof(Stored);
  alignas(64) std::byte unpacked[kLeaf * kLeaf * kLeaf * sizeof(Stored)];
  const std::byte* values = keptValues(frame);
  if (values == nullptr && isPlainFrame(frame, bytes)) {
    auto* const planes = reinterpret_cast<std::uint8_t*>(unpacked);
    if (!unpackPlanes(frame, bytes, count * sizeof(T), planes)) return false;
    joinPlanes<Stored>(planes, count, out);
    return true;
  }
  if (values == nullptr) {
    if (!unpackBlocks(frame, bytes, unpacked)) return false;
    values = unpacked;
  }
  for (std::size_t i = 0; i < count; ++i) {
    Stored value;
    std::memcpy(&value, values + i * sizeof value, sizeof value);
    out[i] = static_cast<T>(value);
  }
  return true;
}

}  // namespace kiln
