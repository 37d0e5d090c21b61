#include <fmt/format.h>

#include <boost/crc.hpp>
#include <cstring>
#include <utility>

#include "base/byte_record.h"
#include "base/hash32.h"
#include "ingest/codec/block_codecs.h"
#include "ingest/codec/blosc_frame.h"
#include "ingest/codec/byte_codec.h"
#include "ingest/codec/byte_shuffle.h"
#include "ingest/codec/unpack_codec.h"

namespace kiln {
namespace {

std::unique_ptr<ByteCodec> deflateCodec(const char* name, DeflateWrapper wrapper) {
  return unpackCodec(name, [wrapper](std::span<const std::byte> packed, std::span<std::byte> out) {
    return unpackDeflate(packed, wrapper, out);
  });
}

std::optional<std::size_t> unpackSizedLz4(std::span<const std::byte> packed, std::span<std::byte> out) {
  ByteTaker taker{packed};
  const auto bytes = taker.take<std::uint32_t>();
  if (!taker.ok || bytes > out.size()) return std::nullopt;
  const std::optional<std::size_t> written = unpackLz4(taker.left, out.first(bytes));
  return written == bytes ? written : std::nullopt;
}

// Source: LZ4BlockOutputStream of lz4-java. A block: the magic, a token (codec, level), the packed and the decoded
// size, an XXH32 of the data masked to 28 bits. A block of no data ends the stream.
std::optional<std::size_t> unpackLz4Stream(std::span<const std::byte> packed, std::span<std::byte> out) {
  constexpr char kMagic[] = {'L', 'Z', '4', 'B', 'l', 'o', 'c', 'k'};
  constexpr unsigned kStored = 0x10, kLz4 = 0x20;
  constexpr std::uint32_t kSeed = 0x9747b28c, kChecksumBits = 0x0fffffff;
  ByteTaker taker{packed};
  std::size_t done = 0;
  while (!taker.left.empty()) {
    const std::span<const std::byte> magic = taker.takeBytes(sizeof kMagic);
    const unsigned codec = taker.take<std::uint8_t>() & 0xf0u;
    const auto packed_bytes = taker.take<std::uint32_t>(), bytes = taker.take<std::uint32_t>();
    const auto checksum = taker.take<std::uint32_t>();
    const std::span<const std::byte> block = taker.takeBytes(packed_bytes);
    if (!taker.ok || std::memcmp(magic.data(), kMagic, sizeof kMagic) != 0 || bytes > out.size() - done)
      return std::nullopt;
    if (bytes == 0) return taker.left.empty() ? std::optional(done) : std::nullopt;
    const std::span<std::byte> to = out.subspan(done, bytes);
    if (codec == kStored && block.size() == bytes)
      std::memcpy(to.data(), block.data(), bytes);
    else if (codec != kLz4 || unpackLz4(block, to) != bytes)
      return std::nullopt;
    if ((hash32Of(to, kSeed) & kChecksumBits) != checksum) return std::nullopt;
    done += bytes;
  }
  return std::nullopt;
}

class BloscCodec : public ByteCodec {
 public:
  std::size_t decode(std::span<const std::byte> packed, std::span<std::byte> out,
                     const ChunkPlace& place) const override {
    std::size_t bytes = 0;
    const std::string fault = unpackBlosc(packed, out, bytes);
    if (!fault.empty()) place.fail(fault);
    return bytes;
  }
  std::uint64_t packedBytes(std::uint64_t bytes) const override { return grownBytes(bytes); }
  // A block before its planes are joined, at most the whole frame.
  std::uint64_t scratchBytes(std::uint64_t bytes) const override { return bytes; }
};

class ShuffleCodec : public ByteCodec {
 public:
  explicit ShuffleCodec(std::size_t number_bytes) : number_bytes_(number_bytes) {}
  std::size_t decode(std::span<const std::byte> packed, std::span<std::byte> out,
                     const ChunkPlace& place) const override {
    if (packed.size() > out.size())
      place.fail(fmt::format("{} shuffled bytes are too many {}", packed.size(), roomText(out)));
    joinBytePlanes(packed, number_bytes_, out.data());
    return packed.size();
  }
  std::uint64_t packedBytes(std::uint64_t bytes) const override { return bytes; }

 private:
  std::size_t number_bytes_;
};

bool matchesCrc32c(std::span<const std::byte> data, std::uint32_t checksum) { return crc32cOf(data) == checksum; }

}  // namespace

std::uint32_t crc32cOf(std::span<const std::byte> data) {
  boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true> crc;
  crc.process_bytes(data.data(), data.size());
  return crc.checksum();
}

std::unique_ptr<ByteCodec> gzipCodec() { return deflateCodec("gzip", DeflateWrapper::kGzip); }
std::unique_ptr<ByteCodec> zlibCodec() { return deflateCodec("zlib", DeflateWrapper::kZlib); }
std::unique_ptr<ByteCodec> zstdCodec() { return unpackCodec("Zstandard", &unpackZstd); }
std::unique_ptr<ByteCodec> bzip2Codec() { return unpackCodec("bzip2", &unpackBzip2, kBzip2Bytes); }
std::unique_ptr<ByteCodec> xzCodec() { return unpackCodec("xz", &unpackLzma, kMostLzmaBytes); }
std::unique_ptr<ByteCodec> lz4Codec() { return unpackCodec("LZ4", &unpackSizedLz4); }
std::unique_ptr<ByteCodec> lz4StreamCodec() { return unpackCodec("LZ4", &unpackLz4Stream); }
std::unique_ptr<ByteCodec> bloscCodec() { return std::make_unique<BloscCodec>(); }
std::unique_ptr<ByteCodec> shuffleCodec(std::size_t number_bytes) {
  return std::make_unique<ShuffleCodec>(number_bytes);
}
std::unique_ptr<ByteCodec> crc32cCodec() { return checksumCodec("CRC-32C", &matchesCrc32c); }

}  // namespace kiln
