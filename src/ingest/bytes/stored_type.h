// The types of numbers in foreign files: the types of voxels, and half floats, which become 32-bit floats.
#pragma once

#include <bit>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "grid/voxel_type.h"

namespace kiln {

/// A 16-bit float of IEEE 754.
struct Half {
  std::uint16_t bits;

  explicit operator double() const noexcept {
    const std::uint32_t sign = (bits & 0x8000u) << 16, exponent = (bits >> 10) & 31u, mantissa = bits & 0x3ffu;
    if (exponent == 0) {
      const double magnitude = static_cast<double>(mantissa) * 0x1p-24;
      return sign != 0 ? -magnitude : magnitude;
    }
    const std::uint32_t wide = exponent == 31 ? 255 : exponent + 112;
    return static_cast<double>(std::bit_cast<float>(sign | wide << 23 | mantissa << 13));
  }
};

class StoredType {
 public:
  constexpr StoredType(VoxelType type) : type_(type) {}
  static constexpr StoredType half() {
    StoredType out(VoxelType::f32);
    out.half_ = true;
    return out;
  }

  /// The voxel type that holds every stored value.
  constexpr VoxelType voxel() const { return type_; }
  constexpr bool isHalf() const { return half_; }
  friend constexpr std::size_t sizeOf(const StoredType& type) { return type.half_ ? 2 : sizeOf(type.type_); }

 private:
  VoxelType type_;
  bool half_ = false;
};

/// Calls `f(std::type_identity<T>{})`, where T is Half or the C++ type of the voxel type.
template <class F>
decltype(auto) withStoredType(StoredType type, F&& f) {
  if (type.isHalf()) return std::forward<F>(f)(std::type_identity<Half>{});
  return withVoxelType(type.voxel(), std::forward<F>(f));
}

}  // namespace kiln
