// The numbers of an array in chunks, and the voxels that are made of them.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "grid/voxel_type.h"
#include "ingest/bytes/stored_type.h"
#include "ingest/codec/byte_codec.h"

namespace kiln {

struct StoredNumber {
  StoredType type = VoxelType::u8;
  bool big_endian = false;

  /// unit: bytes.
  std::size_t bytes() const { return sizeOf(type); }
  VoxelType voxelType() const { return type.voxel(); }
  /// "uint16", "float32".
  std::string name() const;
  /// Reinterprets whole numbers as unsigned; floats stay.
  StoredNumber withoutSign() const;
};

/// Returns the number named as in NumPy, Zarr 3 and N5: "uint16", "float64", "bool"; nothing for any other name.
std::optional<StoredNumber> storedNumberNamed(std::string_view name);

/// Calls `read(stored)` with memory for the stored numbers, and converts these to voxels of `number.voxelType()` in the
/// machine's byte order. cost: further memory only if stored numbers and voxels differ in size.
/// throws: exceptions of `read`; Error kFormat at `place` if a whole number of 64 bits does not fit into 32.
void readVoxels(const StoredNumber& number, std::span<std::byte> voxels, const ChunkPlace& place,
                const std::function<void(std::span<std::byte> stored)>& read);

}  // namespace kiln
