// Source: zarr-specs, docs/v3/codecs/sharding-indexed.
#include "export/zarr/zarr_shard.h"

#include <algorithm>
#include <cstdint>

#include "base/byte_record.h"
#include "base/file/path_status.h"
#include "ingest/codec/byte_codec.h"

namespace kiln {
namespace {

// In the index, a missing chunk has this offset and this length.
constexpr std::uint64_t kMissingChunk = UINT64_MAX;

struct ChunkSpan {
  std::uint64_t offset, bytes;
};

std::size_t indexBytes(std::size_t chunks) { return chunks * sizeof(ChunkSpan) + sizeof(std::uint32_t); }

}  // namespace

std::uint64_t writeShard(const std::filesystem::path& path, const std::vector<std::vector<std::byte>>& chunks,
                         FileSystem& disk) {
  std::vector<std::byte> index;
  std::uint64_t end = 0;
  for (const std::vector<std::byte>& chunk : chunks) {
    appendValue(index, chunk.empty() ? ChunkSpan{kMissingChunk, kMissingChunk} : ChunkSpan{end, chunk.size()});
    end += chunk.size();
  }
  appendValue(index, crc32cOf(index));
  disk.makeDirectories(path.parent_path());
  disk.writeOwn(path, [&](const std::filesystem::path& temporary) {
    disk.writeFile(temporary, {}, WritePolicy::kUnsynced);
    for (const std::vector<std::byte>& chunk : chunks)
      if (!chunk.empty()) disk.appendFile(temporary, chunk);
    disk.appendFile(temporary, index);
    // Before the shard has its name: an export that is resumed after a power failure trusts the index.
    disk.syncFile(temporary);
  });
  return end + index.size();
}

std::uint64_t wholeShardBytes(const std::filesystem::path& path, std::size_t chunks) {
  if (!isThere(path)) return 0;
  const File file(path);
  std::vector<std::byte> index(indexBytes(chunks));
  if (file.size() < index.size()) return 0;
  const std::uint64_t chunks_end = file.size() - index.size();
  file.readAt(chunks_end, index);
  ByteTaker taker{index};
  std::uint64_t end = 0;
  for (std::size_t i = 0; i < chunks; ++i) {
    const auto chunk = taker.take<ChunkSpan>();
    if (chunk.offset == kMissingChunk) continue;
    if (chunk.offset != end || chunk.bytes > chunks_end - end) return 0;
    end += chunk.bytes;
  }
  const std::span<const std::byte> spans = std::span<const std::byte>(index).first(chunks * sizeof(ChunkSpan));
  return taker.take<std::uint32_t>() == crc32cOf(spans) && end == chunks_end ? file.size() : 0;
}

}  // namespace kiln
