// The numbers of an array in chunks, and the voxels that are made of them.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "grid/voxel_type.h"
#include "ingest/codec/byte_codec.h"

namespace kiln {

enum class NumberKind { kUnsigned, kSigned, kFloat };

struct StoredNumber {
  NumberKind kind = NumberKind::kUnsigned;
  /// 1, 2, 4 or 8; floats have 2 at least.
  std::size_t bytes = 1;
  bool big_endian = false;

  /// Half floats become f32; whole numbers of 64 bits become 32 bits, and must fit.
  VoxelType voxelType() const;
  /// "uint16", "float32".
  std::string name() const;
};

/// Returns the number named as in NumPy, Zarr 3 and N5: "uint16", "float64", "bool"; nothing for any other name.
std::optional<StoredNumber> storedNumberNamed(std::string_view name);

/// Calls `read(stored)` with memory for the stored numbers, and converts these to voxels of `number.voxelType()` in the
/// machine's byte order. cost: further memory only if stored numbers and voxels differ in size.
/// throws: exceptions of `read`; Error kFormat at `place` if a whole number of 64 bits does not fit into 32.
void readVoxels(const StoredNumber& number, std::span<std::byte> voxels, const ChunkPlace& place,
                const std::function<void(std::span<std::byte> stored)>& read);

}  // namespace kiln
