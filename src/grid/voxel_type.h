// The scalar types of voxels, and the run-time selection of code that is a template over them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>

namespace kiln {

enum class VoxelType : std::uint8_t { u8, i8, u16, i16, u32, i32, f32, f64 };

/// unit: bytes.
constexpr std::size_t sizeOf(VoxelType type) {
  switch (type) {
    case VoxelType::u8:
    case VoxelType::i8:
      return 1;
    case VoxelType::u16:
    case VoxelType::i16:
      return 2;
    case VoxelType::u32:
    case VoxelType::i32:
    case VoxelType::f32:
      return 4;
    case VoxelType::f64:
      return 8;
  }
  return 0;
}

constexpr std::string_view nameOf(VoxelType type) {
  constexpr std::string_view kNames[] = {"u8", "i8", "u16", "i16", "u32", "i32", "f32", "f64"};
  return kNames[static_cast<std::size_t>(type)];
}

/// Returns nothing if no type has this name.
constexpr std::optional<VoxelType> voxelTypeNamed(std::string_view name) {
  for (int i = 0; i < 8; ++i) {
    if (nameOf(static_cast<VoxelType>(i)) == name) return static_cast<VoxelType>(i);
  }
  return std::nullopt;
}

constexpr bool isFloating(VoxelType type) { return type == VoxelType::f32 || type == VoxelType::f64; }

/// Calls `f(std::type_identity<T>{})`, where T is the C++ type of `type`.
template <class F>
decltype(auto) withVoxelType(VoxelType type, F&& f) {
  switch (type) {
    case VoxelType::u8:
      return std::forward<F>(f)(std::type_identity<std::uint8_t>{});
    case VoxelType::i8:
      return std::forward<F>(f)(std::type_identity<std::int8_t>{});
    case VoxelType::u16:
      return std::forward<F>(f)(std::type_identity<std::uint16_t>{});
    case VoxelType::i16:
      return std::forward<F>(f)(std::type_identity<std::int16_t>{});
    case VoxelType::u32:
      return std::forward<F>(f)(std::type_identity<std::uint32_t>{});
    case VoxelType::i32:
      return std::forward<F>(f)(std::type_identity<std::int32_t>{});
    case VoxelType::f32:
      return std::forward<F>(f)(std::type_identity<float>{});
    case VoxelType::f64:
      break;
  }
  return std::forward<F>(f)(std::type_identity<double>{});
}

}  // namespace kiln
