// Reads a box of voxels out of a file that stores voxels x fastest: rows of equal length at equal distances.
#pragma once

#include "base/file/file.h"

namespace kiln {

/// Reads `rows` rows of `row_bytes` bytes and packs them densely at `out`. The first row begins at byte `first`; each
/// row begins `stride` bytes behind the row before.
/// throws: Error kFormat if the file ends too early, kIo. cost: rows that are close together share a read of up to
/// 64 KiB.
void gatherRows(const File& file, std::uint64_t first, std::uint64_t rows, std::uint64_t row_bytes,
                std::uint64_t stride, std::byte* out);

}  // namespace kiln
