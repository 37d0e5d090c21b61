// The types of numbers in NumPy's notation, as .npy files and Zarr 2 write them: "<u2" is a byte order, a kind and a
// number of bytes. Source: numpy.org/doc/stable/reference/arrays.interface.html.
#pragma once

#include <optional>
#include <string_view>

#include "ingest/bytes/stored_type.h"

namespace kiln {

struct NumpyTypeText {
  /// '<' for little-endian, '>' for big-endian; any other character names no order.
  char order = ' ';
  /// "u2".
  std::string_view code;
};

/// Splits "<u2" into the order and the code.
constexpr NumpyTypeText numpyTypeText(std::string_view text) {
  const bool ordered = !text.empty() && std::string_view("<>|=").find(text.front()) != std::string_view::npos;
  return ordered ? NumpyTypeText{text.front(), text.substr(1)} : NumpyTypeText{' ', text};
}

/// Returns the type of a code without an order; nothing for elements that are not one number of 8 to 64 bits.
constexpr std::optional<StoredType> numpyTypeOf(std::string_view code) {
  struct Named {
    std::string_view code;
    StoredType type;
  };
  // NumPy counts bytes: its u8 has 64 bits.
  constexpr Named kTypes[] = {{"u1", VoxelType::u8},           {"i1", VoxelType::i8},          {"u2", VoxelType::u16},
                              {"i2", VoxelType::i16},          {"u4", VoxelType::u32},         {"i4", VoxelType::i32},
                              {"u8", StoredType::wide(false)}, {"i8", StoredType::wide(true)}, {"f4", VoxelType::f32},
                              {"f8", VoxelType::f64},          {"f2", StoredType::half()}};
  for (const Named& known : kTypes)
    if (code == known.code) return known.type;
  return std::nullopt;
}

}  // namespace kiln
