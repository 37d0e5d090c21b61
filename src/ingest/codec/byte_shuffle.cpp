#include "ingest/codec/byte_shuffle.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstdint>

#include "base/vectors.h"

namespace kiln {

// Not in an anonymous namespace: GCC's selection of a version needs a name with external linkage.
template <std::size_t kSize>
KILN_VECTORS void joinPlanesOf(const std::byte* __restrict planes, std::size_t count,
                               std::byte* __restrict out) noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t b = 0; b < kSize; ++b) out[i * kSize + b] = planes[b * count + i];
  }
}

template <std::size_t kSize>
KILN_VECTORS void splitPlanesOf(const std::byte* __restrict numbers, std::size_t count,
                                std::byte* __restrict planes) noexcept {
  for (std::size_t b = 0; b < kSize; ++b) {
    for (std::size_t i = 0; i < count; ++i) planes[b * count + i] = numbers[i * kSize + b];
  }
}

namespace {

// Transposes a matrix of 8 × 8 bits, row r in byte r. Source: Warren, Hacker's Delight, 7-3.
std::uint64_t transposed(std::uint64_t bits) noexcept {
  std::uint64_t t = (bits ^ (bits >> 7)) & 0x00AA00AA00AA00AAull;
  bits ^= t ^ (t << 7);
  t = (bits ^ (bits >> 14)) & 0x0000CCCC0000CCCCull;
  bits ^= t ^ (t << 14);
  t = (bits ^ (bits >> 28)) & 0x00000000F0F0F0F0ull;
  return bits ^ t ^ (t << 28);
}

}  // namespace

void joinBytePlanes(std::span<const std::byte> planes, std::size_t size, std::byte* out) noexcept {
  const std::size_t count = planes.size() / size;
  switch (size) {
    case 1:
      break;
    case 2:
      joinPlanesOf<2>(planes.data(), count, out);
      break;
    case 4:
      joinPlanesOf<4>(planes.data(), count, out);
      break;
    case 8:
      joinPlanesOf<8>(planes.data(), count, out);
      break;
    default:
      for (std::size_t b = 0; b < size; ++b) {
        for (std::size_t i = 0; i < count; ++i) out[i * size + b] = planes[b * count + i];
      }
  }
  const std::size_t joined = size == 1 ? 0 : count * size;
  std::copy(planes.begin() + static_cast<std::ptrdiff_t>(joined), planes.end(), out + joined);
}

void splitBytePlanes(std::span<const std::byte> numbers, std::size_t size, std::byte* planes) noexcept {
  const std::size_t count = numbers.size() / size;
  switch (size) {
    case 1:
      break;
    case 2:
      splitPlanesOf<2>(numbers.data(), count, planes);
      break;
    case 4:
      splitPlanesOf<4>(numbers.data(), count, planes);
      break;
    case 8:
      splitPlanesOf<8>(numbers.data(), count, planes);
      break;
    default:
      for (std::size_t b = 0; b < size; ++b) {
        for (std::size_t i = 0; i < count; ++i) planes[b * count + i] = numbers[i * size + b];
      }
  }
  const std::size_t split = size == 1 ? 0 : count * size;
  std::copy(numbers.begin() + static_cast<std::ptrdiff_t>(split), numbers.end(), planes + split);
}

void joinBitPlanes(std::span<const std::byte> planes, std::size_t size, std::byte* out) noexcept {
  static_assert(std::endian::native == std::endian::little, "bytes of a number are taken from the lowest");
  const std::size_t count = planes.size() / size, row = count / 8;
  assert(planes.size() == count * size && count % 8 == 0);
  for (std::size_t b = 0; b < size; ++b) {
    const std::byte* const plane = planes.data() + b * 8 * row;
    for (std::size_t i = 0; i < row; ++i) {
      std::uint64_t bits = 0;
      for (std::size_t k = 0; k < 8; ++k) bits |= std::to_integer<std::uint64_t>(plane[k * row + i]) << (8 * k);
      bits = transposed(bits);
      std::byte* const to = out + i * 8 * size + b;
      for (std::size_t e = 0; e < 8; ++e) to[e * size] = static_cast<std::byte>(bits >> (8 * e));
    }
  }
}

}  // namespace kiln
