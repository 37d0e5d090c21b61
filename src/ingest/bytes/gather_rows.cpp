// Many rows of a brick are shorter than a memory page, so the number of read calls costs more than the bytes.
#include "ingest/bytes/gather_rows.h"

#include <algorithm>
#include <cstring>

namespace kiln {

void gatherRows(const File& file, std::uint64_t first, std::uint64_t rows, std::uint64_t row_bytes,
                std::uint64_t stride, std::byte* out) {
  constexpr std::uint64_t kChunkBytes = 1 << 20;
  // Short rows close together: one read over the gaps moves less than twice the bytes and saves a call per row.
  const bool together = rows > 1 && stride < 2 * row_bytes && stride + row_bytes <= kChunkBytes;
  const std::uint64_t group = together ? (kChunkBytes - row_bytes) / stride + 1 : 1;
  std::vector<std::byte> run(together ? static_cast<std::size_t>((std::min(group, rows) - 1) * stride + row_bytes) : 0);
  for (std::uint64_t r = 0; r < rows; r += group, first += group * stride) {
    const std::uint64_t count = std::min(group, rows - r);
    if (!together) {
      file.readAt(first, {out, static_cast<std::size_t>(row_bytes)});
      out += row_bytes;
      continue;
    }
    file.readAt(first, std::span(run).first(static_cast<std::size_t>((count - 1) * stride + row_bytes)));
    for (std::uint64_t i = 0; i < count; ++i, out += row_bytes) std::memcpy(out, run.data() + i * stride, row_bytes);
  }
}

}  // namespace kiln
