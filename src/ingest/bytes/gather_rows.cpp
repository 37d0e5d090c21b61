// Many rows of a brick are shorter than a memory page, so the number of read calls costs more than the bytes.
#include "ingest/bytes/gather_rows.h"

#include <algorithm>
#include <cstring>
#include <memory>

namespace kiln {

void gatherRows(const File& file, std::uint64_t first, std::uint64_t rows, std::uint64_t row_bytes,
                std::uint64_t stride, std::byte* out) {
  constexpr std::uint64_t kPageBytes = 4096, kChunkBytes = 1 << 16;
  // One read over the gaps saves a call per row. It moves less than twice the bytes, or rows share pages, which a disk
  // gives whole.
  const bool together =
      rows > 1 && (stride < 2 * row_bytes || stride <= kPageBytes) && stride + row_bytes <= kChunkBytes;
  const std::uint64_t group = together ? (kChunkBytes - row_bytes) / stride + 1 : 1;
  const auto run = std::make_unique_for_overwrite<std::byte[]>(
      together ? static_cast<std::size_t>((std::min(group, rows) - 1) * stride + row_bytes) : 0);
  for (std::uint64_t r = 0; r < rows; r += group, first += group * stride) {
    const std::uint64_t count = std::min(group, rows - r);
    if (!together) {
      file.readAt(first, {out, static_cast<std::size_t>(row_bytes)});
      out += row_bytes;
      continue;
    }
    file.readAt(first, {run.get(), static_cast<std::size_t>((count - 1) * stride + row_bytes)});
    for (std::uint64_t i = 0; i < count; ++i, out += row_bytes) std::memcpy(out, run.get() + i * stride, row_bytes);
  }
}

}  // namespace kiln
