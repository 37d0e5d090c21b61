// The types of numbers in foreign files: the types of voxels, half floats, which become 32-bit floats, and 64-bit
// integers, which become 32-bit integers if they fit.
#pragma once

#include <bit>
#include <cstdint>
#include <string_view>
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
  static constexpr StoredType half() { return {VoxelType::f32, Width::kHalf}; }
  /// Integers of 64 bits, signed or not.
  static constexpr StoredType wide(bool is_signed) {
    return {is_signed ? VoxelType::i32 : VoxelType::u32, Width::kWide};
  }

  /// The voxel type that holds the stored values, of wide integers the values that fit.
  constexpr VoxelType voxel() const { return type_; }
  constexpr bool isHalf() const { return width_ == Width::kHalf; }
  constexpr bool isWide() const { return width_ == Width::kWide; }
  /// True if stored values and voxels have the same bytes, except for the byte order.
  constexpr bool isVoxel() const { return width_ == Width::kSame; }
  constexpr bool operator==(const StoredType&) const = default;
  friend constexpr std::size_t sizeOf(const StoredType& type) {
    return type.isHalf() ? 2 : type.isWide() ? 8 : sizeOf(type.type_);
  }

 private:
  enum class Width { kSame, kHalf, kWide };
  constexpr StoredType(VoxelType type, Width width) : type_(type), width_(width) {}

  VoxelType type_;
  Width width_ = Width::kSame;
};

/// "f16", "i64" and "u64", or the name of the voxel type.
constexpr std::string_view nameOf(const StoredType& type) {
  if (type.isHalf()) return "f16";
  if (type.isWide()) return type.voxel() == VoxelType::i32 ? "i64" : "u64";
  return nameOf(type.voxel());
}

/// Calls `f(std::type_identity<T>{})`, where T is Half, a 64-bit integer or the C++ type of the voxel type.
template <class F>
decltype(auto) withStoredType(StoredType type, F&& f) {
  if (type.isHalf()) return std::forward<F>(f)(std::type_identity<Half>{});
  if (type.isWide() && type.voxel() == VoxelType::i32) return std::forward<F>(f)(std::type_identity<std::int64_t>{});
  if (type.isWide()) return std::forward<F>(f)(std::type_identity<std::uint64_t>{});
  return withVoxelType(type.voxel(), std::forward<F>(f));
}

}  // namespace kiln
