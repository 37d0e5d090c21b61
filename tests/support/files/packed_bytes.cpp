#include "support/files/packed_bytes.h"

#include <blosc.h>
#include <bzlib.h>
#include <lz4.h>
#include <lzma.h>
#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <random>
#include <stdexcept>

namespace kiln::test {

std::string littleEndian(std::uint64_t number, std::size_t bytes) {
  std::string out;
  for (std::size_t i = 0; i < bytes; ++i) out += static_cast<char>(number >> (8 * i) & 0xff);
  return out;
}

std::string bigEndian(std::uint64_t number, std::size_t bytes) {
  std::string out = littleEndian(number, bytes);
  std::reverse(out.begin(), out.end());
  return out;
}

std::string bzipped(std::string_view bytes) {
  std::string out(bytes.size() + bytes.size() / 100 + 600, '\0');
  auto size = static_cast<unsigned>(out.size());
  if (BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(bytes.data()), static_cast<unsigned>(bytes.size()),
                               1, 0, 0) != BZ_OK)
    throw std::runtime_error("bzip2");
  out.resize(size);
  return out;
}

namespace {

// An encoder of LZMA. The library keeps its buffers, some MiB, for the next block: a test's file has hundreds.
struct LzmaEncoder {
  ~LzmaEncoder() { lzma_end(&stream); }
  lzma_stream stream = LZMA_STREAM_INIT;
};

}  // namespace

std::string xzStream(std::string_view bytes) {
  std::string out(bytes.size() + 4096, '\0');
  static thread_local LzmaEncoder encoder;
  lzma_stream& stream = encoder.stream;
  const lzma_ret begun = lzma_easy_encoder(&stream, 0, LZMA_CHECK_CRC32);
  stream.next_in = reinterpret_cast<const std::uint8_t*>(bytes.data()), stream.avail_in = bytes.size();
  stream.next_out = reinterpret_cast<std::uint8_t*>(out.data()), stream.avail_out = out.size();
  if (begun != LZMA_OK || lzma_code(&stream, LZMA_FINISH) != LZMA_STREAM_END) throw std::runtime_error("LZMA");
  out.resize(static_cast<std::size_t>(stream.total_out));
  return out;
}

std::string zstdFrame(std::string_view bytes, bool sized) {
  ZSTD_CCtx* const context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, sized ? 1 : 0);
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t packed = ZSTD_compress2(context, out.data(), out.size(), bytes.data(), bytes.size());
  ZSTD_freeCCtx(context);
  if (ZSTD_isError(packed)) throw std::runtime_error("Zstandard");
  out.resize(packed);
  return out;
}

std::string lz4Block(std::string_view bytes) {
  std::string out(static_cast<std::size_t>(LZ4_compressBound(static_cast<int>(bytes.size()))), '\0');
  const int packed =
      LZ4_compress_default(bytes.data(), out.data(), static_cast<int>(bytes.size()), static_cast<int>(out.size()));
  if (packed <= 0) throw std::runtime_error("LZ4");
  out.resize(static_cast<std::size_t>(packed));
  return out;
}

std::string sizedLz4(std::string_view bytes) { return littleEndian(bytes.size(), 4) + lz4Block(bytes); }

std::string lz4Stream(std::string_view bytes, std::size_t block_bytes) {
  std::string out;
  for (std::size_t at = 0; at < bytes.size(); at += block_bytes) {
    const std::string_view block = bytes.substr(at, block_bytes);
    const std::string packed = lz4Block(block);
    const bool stored = packed.size() >= block.size();
    const std::uint32_t checksum = XXH32(block.data(), block.size(), 0x9747b28c) & 0x0fffffff;
    out += "LZ4Block";
    out += static_cast<char>(stored ? 0x16 : 0x26);
    out += littleEndian(stored ? block.size() : packed.size(), 4) + littleEndian(block.size(), 4);
    out += littleEndian(checksum, 4);
    out += stored ? block : packed;
  }
  return out + "LZ4Block\x16" + std::string(12, '\0');
}

std::string bloscFrame(std::string_view bytes, const BloscSpec& spec) {
  std::string out(bytes.size() + BLOSC_MAX_OVERHEAD, '\0');
  const int packed = blosc_compress_ctx(spec.level, spec.shuffle, spec.number_bytes, bytes.size(), bytes.data(),
                                        out.data(), out.size(), spec.codec, spec.block_bytes, 1);
  if (packed <= 0) throw std::runtime_error("Blosc");
  out.resize(static_cast<std::size_t>(packed));
  return out;
}

std::string shuffled(std::string_view bytes, std::size_t number_bytes) {
  const std::size_t count = bytes.size() / number_bytes;
  std::string out;
  for (std::size_t b = 0; b < number_bytes; ++b)
    for (std::size_t i = 0; i < count; ++i) out += bytes[i * number_bytes + b];
  return out.append(bytes.substr(count * number_bytes));
}

// The reversed polynomial of Castagnoli.
std::uint32_t crc32cOf(std::string_view bytes) {
  std::uint32_t crc = 0xffffffff;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1u) != 0 ? 0x82f63b78u : 0u);
  }
  return ~crc;
}

std::string withCrc32c(std::string_view bytes) { return std::string(bytes) + littleEndian(crc32cOf(bytes), 4); }

std::string noiseBytes(std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::string out(count, '\0');
  std::generate(out.begin(), out.end(), [&] { return static_cast<char>(random() >> 32); });
  return out;
}

std::string smoothBytes(std::size_t count) {
  std::string out;
  for (std::size_t i = 0; out.size() < count; ++i) out += littleEndian(1000 + i / 5, 4);
  out.resize(count);
  return out;
}

}  // namespace kiln::test
