// The header of a NumPy file: the type, the memory order and the shape of an array.
#pragma once

#include <cstdint>
#include <vector>

#include "base/file/file.h"
#include "ingest/bytes/stored_type.h"

namespace kiln {

struct NpyHeader {
  StoredType type = VoxelType::u8;
  bool big_endian = false;
  /// True if the first axis is consecutive in the file, false if the last axis is.
  bool fortran_order = false;
  /// Lengths of the axes in the order of the array's indices; not checked beyond being whole numbers of 63 bits.
  std::vector<std::int64_t> shape;
  /// Begin of the voxels. unit: bytes into the file.
  std::uint64_t end_offset = 0;
};

/// throws: Error kFormat if the file is not NumPy's or its header is not the dictionary of an array; kUnsupported for a
/// later version, and for elements that are not one number of a VoxelType.
NpyHeader readNpyHeader(const File& file);

}  // namespace kiln
