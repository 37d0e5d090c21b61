#include <bzlib.h>

#include <new>

#include "ingest/codec/block_codecs.h"

namespace kiln {

std::optional<std::size_t> unpackBzip2(std::span<const std::byte> packed, std::span<std::byte> out) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) throw std::bad_alloc();
  stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(packed.data()));
  stream.avail_in = static_cast<unsigned>(packed.size());
  stream.next_out = reinterpret_cast<char*>(out.data());
  stream.avail_out = static_cast<unsigned>(out.size());
  const int verdict = BZ2_bzDecompress(&stream);
  const std::size_t written = out.size() - stream.avail_out;
  const bool whole = verdict == BZ_STREAM_END && stream.avail_in == 0;
  BZ2_bzDecompressEnd(&stream);
  if (verdict == BZ_MEM_ERROR) throw std::bad_alloc();
  return whole ? std::optional(written) : std::nullopt;
}

}  // namespace kiln
