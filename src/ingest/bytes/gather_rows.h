// A box of voxels out of a file that holds them x fastest: rows of equal length at equal distances.
#pragma once

#include "base/file.h"

namespace kiln {

/// Reads `rows` rows of `row_bytes` each, the first at byte `first`, each `stride` bytes behind the one before, and
/// packs them densely at `out`. throws: Error kFormat where the file ends before, kIo. cost: rows that are close
/// together share a read of up to 1 MiB.
void gatherRows(const File& file, std::uint64_t first, std::uint64_t rows, std::uint64_t row_bytes,
                std::uint64_t stride, std::byte* out);

}  // namespace kiln
