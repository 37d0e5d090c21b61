// Codecs of chunks. Known because each library's own encoder made the packed bytes; checksums have published answers.
// Damaged bytes are an Error, or the exact bytes, and never reach memory beyond the output.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <random>

#include "base/error.h"
#include "ingest/codec/byte_codec.h"
#include "ingest/codec/byte_shuffle.h"
#include "support/files/foreign_files.h"
#include "support/files/packed_bytes.h"
#include "support/system/sanitized.h"

namespace kiln::test {
namespace {

constexpr std::size_t kGuardBytes = 64;
constexpr char kGuard = '\x5a';

CodecChain chainOf(std::unique_ptr<ByteCodec> codec) {
  CodecChain out;
  out.add(std::move(codec));
  return out;
}

// Decodes to `bytes` bytes; nothing for an Error, which is a line that names the chunk. Expects that the bytes behind
// the output stay as they are.
std::optional<std::string> decoded(const CodecChain& chain, std::string_view packed, std::size_t bytes) {
  // A copy of exact length, so that a sanitizer finds each read beyond the end.
  const std::vector<char> exact(packed.begin(), packed.end());
  std::string out(bytes + kGuardBytes, kGuard);
  try {
    chain.decode(std::as_bytes(std::span(exact)), std::as_writable_bytes(std::span(out).first(bytes)),
                 {"f", "chunk 3"});
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFormat);
    EXPECT_EQ(std::string(error.what()).find("f: chunk 3: "), 0u) << error.what();
    EXPECT_EQ(out.find_first_not_of(kGuard, bytes), std::string::npos) << "bytes behind the output were written";
    return std::nullopt;
  }
  EXPECT_EQ(out.find_first_not_of(kGuard, bytes), std::string::npos) << "bytes behind the output were written";
  out.resize(bytes);
  return out;
}

struct CodecCase {
  const char* name;
  std::function<std::unique_ptr<ByteCodec>()> codec;
  std::function<std::string(std::string_view)> pack;
  /// True if a checksum finds every single flipped bit of the data.
  bool has_checksum = false;
};

std::vector<CodecCase> codecs() {
  const auto blosc = [](const BloscSpec& spec) { return [=](std::string_view b) { return bloscFrame(b, spec); }; };
  return {
      {"gzip", &gzipCodec, [](std::string_view b) { return gzipped(b); }, true},
      {"zlib", &zlibCodec, &zlibbed, true},
      {"zstd", &zstdCodec, [](std::string_view b) { return zstdFrame(b); }},
      {"zstd, size unknown", &zstdCodec, [](std::string_view b) { return zstdFrame(b, false); }},
      {"lz4", &lz4Codec, &sizedLz4},
      {"lz4 stream", &lz4StreamCodec, [](std::string_view b) { return lz4Stream(b, 100); }, true},
      {"blosc lz4", &bloscCodec, blosc({.block_bytes = 256})},
      {"blosc zstd bits", &bloscCodec, blosc({.codec = "zstd", .shuffle = 2, .number_bytes = 4})},
      {"blosc zlib", &bloscCodec, blosc({.codec = "zlib", .shuffle = 0})},
      {"blosc blosclz", &bloscCodec, blosc({.codec = "blosclz", .block_bytes = 512})},
      {"blosc kept", &bloscCodec, blosc({.level = 0})},
      {"shuffle", [] { return shuffleCodec(4); }, [](std::string_view b) { return shuffled(b, 4); }},
      {"crc32c", &crc32cCodec, &withCrc32c, true},
  };
}

TEST(Codec, EachReadsWhatItsLibraryWrites) {
  for (const CodecCase& codec : codecs()) {
    const CodecChain chain = chainOf(codec.codec());
    for (const std::size_t bytes : {1, 3, 16, 255, 1000, 70001}) {
      for (const std::string& data : {noiseBytes(bytes, bytes), smoothBytes(bytes)}) {
        SCOPED_TRACE(fmt::format("{}, {} bytes", codec.name, bytes));
        const std::string packed = codec.pack(data);
        EXPECT_EQ(decoded(chain, packed, bytes), data);
        EXPECT_LE(packed.size(), chain.packedBytes(bytes));
        // A chunk of another size than the array's.
        EXPECT_EQ(decoded(chain, packed, bytes - 1), std::nullopt);
        EXPECT_EQ(decoded(chain, packed, bytes + 1), std::nullopt);
        EXPECT_EQ(decoded(chain, "", bytes), std::nullopt);
      }
    }
  }
}

// Numbers of all sizes, counts that are no multiple of eight, blocks from 128 bytes to the whole frame, last blocks of
// any length.
TEST(Codec, BloscReadsEveryOrderOfBytesAndBlocks) {
  const CodecChain chain = chainOf(bloscCodec());
  for (const char* const codec : {"blosclz", "lz4", "lz4hc", "zstd", "zlib"}) {
    for (const std::size_t number_bytes : {1, 2, 3, 4, 8, 16, 17}) {
      for (const int shuffle : {0, 1, 2}) {
        for (const std::size_t block_bytes : {0, 128, 1000, 4096}) {
          for (const std::size_t bytes : {1, 17, 1003, 9001}) {
            const std::string data = smoothBytes(bytes);
            const std::string packed = bloscFrame(data, {codec, shuffle, number_bytes, block_bytes});
            EXPECT_TRUE(decoded(chain, packed, bytes) == data)
                << codec << ", numbers of " << number_bytes << ", shuffle " << shuffle << ", blocks of " << block_bytes
                << ", " << bytes << " bytes";
          }
        }
      }
    }
  }
}

// Matches of all lengths and distances: noise that repeats after up to 70,000 bytes, in runs of up to 600 bytes.
TEST(Codec, BlosclzReadsNearAndFarMatches) {
  const CodecChain chain = chainOf(bloscCodec());
  for (const std::size_t distance : {1, 2, 255, 256, 8191, 8192, 8193, 8447, 20000, 70000}) {
    std::string data = noiseBytes(distance, 7);
    for (std::size_t run = 1; data.size() < 250'000; run = run * 5 % 601) {
      for (std::size_t i = 0; i < run; ++i) data += data[data.size() - distance];
      data += static_cast<char>(run);
    }
    const std::string packed =
        bloscFrame(data, {.codec = "blosclz", .shuffle = 0, .number_bytes = 1, .block_bytes = 1 << 18, .level = 9});
    EXPECT_TRUE(decoded(chain, packed, data.size()) == data) << distance;
  }
}

TEST(Codec, BloscOfOtherCodecsIsRefusedByName) {
  const std::string data = smoothBytes(5000);
  const CodecChain chain = chainOf(bloscCodec());
  std::string out(data.size(), '\0');
  const auto refused = [&](std::string_view packed, const std::string& part) {
    const auto decode = [&] {
      chain.decode(std::as_bytes(std::span(packed)), std::as_writable_bytes(std::span(out)), {"f", ""});
    };
    expectError(decode, ErrorCode::kFormat, part);
  };
  std::string frame = bloscFrame(data, {});
  for (const auto& [codec, part] : {std::pair{2, "Snappy inside Blosc is not read"}, {7, "codec 7 inside Blosc"}}) {
    frame[2] = static_cast<char>((frame[2] & 0x1f) | codec << 5);
    refused(frame, part);
  }
  frame[0] = 5;
  refused(frame, "version 5 of Blosc is unknown");
}

// Published: RFC 3720, B.4, and the catalogue of CRC algorithms.
TEST(Codec, Crc32cHasThePublishedAnswers) {
  std::string rising;
  for (char i = 0; i < 32; ++i) rising += i;
  const std::pair<std::string, std::uint32_t> cases[] = {{"123456789", 0xe3069283u},
                                                         {std::string(32, '\0'), 0x8a9136aau},
                                                         {std::string(32, '\xff'), 0x62a8ab43u},
                                                         {rising, 0x46dd794eu}};
  const CodecChain chain = chainOf(crc32cCodec());
  for (const auto& [data, crc] : cases) {
    EXPECT_EQ(decoded(chain, data + littleEndian(crc, 4), data.size()), data);
    EXPECT_EQ(decoded(chain, data + littleEndian(crc ^ 1, 4), data.size()), std::nullopt);
  }
}

TEST(Codec, GzipOfSeveralMembersIsOneStream) {
  const std::string data = smoothBytes(1000);
  const CodecChain chain = chainOf(gzipCodec());
  EXPECT_EQ(decoded(chain, gzipped(data.substr(0, 300)) + gzipped(data.substr(300)), 1000), data);
  EXPECT_EQ(decoded(chain, gzipped(data) + gzipped(""), 1000), data);
  EXPECT_EQ(decoded(chain, gzipped(data) + "x", 1000), std::nullopt);
  EXPECT_EQ(decoded(chain, gzipped(data) + gzipped("x"), 1000), std::nullopt);
  EXPECT_EQ(decoded(chainOf(zlibCodec()), zlibbed(data.substr(0, 300)) + zlibbed(data.substr(300)), 1000),
            std::nullopt);
}

// No bytes at all, and chunks without bytes.
TEST(Codec, DeflateOfNothing) {
  for (const CodecChain& chain : {chainOf(gzipCodec()), chainOf(zlibCodec())}) {
    EXPECT_EQ(decoded(chain, "", 0), std::nullopt);
    EXPECT_EQ(decoded(chain, "", 10), std::nullopt);
  }
  EXPECT_EQ(decoded(chainOf(gzipCodec()), gzipped(""), 0), "");
  EXPECT_EQ(decoded(chainOf(zlibCodec()), zlibbed(""), 0), "");
  EXPECT_EQ(decoded(chainOf(zlibCodec()), zlibbed("x"), 0), std::nullopt);
}

TEST(Codec, SeveralZstdFramesAreOneStream) {
  const std::string data = smoothBytes(1000);
  const std::string frames = zstdFrame(data.substr(0, 300), false) + zstdFrame(data.substr(300));
  EXPECT_EQ(decoded(chainOf(zstdCodec()), frames, 1000), data);
}

// Known: 13 bytes of a frame that states 1.1 TB; an LZ4 block that states 4 GB.
TEST(Codec, DecodedSizesThatLie_TakeNoMemory) {
  const std::string frame = std::string("\x28\xb5\x2f\xfd\xe0", 5) + littleEndian(std::uint64_t{1} << 40, 8);
  EXPECT_EQ(decoded(chainOf(zstdCodec()), frame, 100), std::nullopt);
  EXPECT_EQ(decoded(chainOf(lz4Codec()), littleEndian(0xffffffff, 4) + lz4Block("abcd"), 4), std::nullopt);
  std::string blosc = bloscFrame(smoothBytes(1000), {});
  for (const std::size_t field : {4, 8, 12}) {
    for (const std::uint64_t lie : {0ull, 1ull, 999ull, 1001ull, 0x7fffffffull, 0xffffffffull}) {
      std::string lying = blosc;
      lying.replace(field, 4, littleEndian(lie, 4));
      const std::optional<std::string> got = decoded(chainOf(bloscCodec()), lying, 1000);
      EXPECT_TRUE(!got || *got == smoothBytes(1000)) << field << " " << lie;
    }
  }
}

TEST(Codec, ChainDecodesFromTheLastCodecToTheFirst) {
  CodecChain chain;
  chain.add(shuffleCodec(2));
  chain.add(zlibCodec());
  chain.add(crc32cCodec());
  const std::string data = smoothBytes(5001);
  EXPECT_EQ(decoded(chain, withCrc32c(zlibbed(shuffled(data, 2))), data.size()), data);
  EXPECT_EQ(decoded(chain, zlibbed(shuffled(data, 2)), data.size()), std::nullopt);
  EXPECT_EQ(decoded(CodecChain(), data, data.size()), data);
  EXPECT_EQ(decoded(CodecChain(), data, data.size() - 1), std::nullopt);
  EXPECT_GE(chain.scratchBytes(5001), 2 * 5001u);
}

// Known: number i has bit i and no other bit.
TEST(Codec, BitPlanesHoldTheFirstNumberInTheLowestBit) {
  const unsigned char planes[8] = {1, 2, 4, 8, 16, 32, 64, 128};
  std::byte out[8];
  joinBitPlanes(std::as_bytes(std::span(planes)), 1, out);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(std::to_integer<int>(out[i]), 1 << i);
}

TEST(Codec, EveryTruncationIsAnErrorOrExact) {
  for (const CodecCase& codec : codecs()) {
    const CodecChain chain = chainOf(codec.codec());
    for (const std::string& data : {noiseBytes(300, 1), smoothBytes(901)}) {
      const std::string packed = codec.pack(data);
      for (std::size_t length = 0; length < packed.size(); ++length) {
        const std::optional<std::string> got = decoded(chain, packed.substr(0, length), data.size());
        EXPECT_TRUE(!got || *got == data) << codec.name << " cut to " << length << " of " << packed.size();
      }
    }
  }
}

// A flipped bit of bytes without a checksum may give other bytes.
TEST(Codec, FlippedBitsAreHarmless) {
  std::mt19937_64 random(21);
  const std::string data = smoothBytes(777);
  for (const CodecCase& codec : codecs()) {
    const CodecChain chain = chainOf(codec.codec());
    const std::string packed = codec.pack(data);
    for (int i = 0; i < casesOf(10'000, 1'000); ++i) {
      std::string damaged = packed;
      damaged[random() % damaged.size()] ^= static_cast<char>(1u << (random() % 8));
      const std::optional<std::string> got = decoded(chain, damaged, data.size());
      EXPECT_TRUE(!codec.has_checksum || !got || *got == data) << codec.name << ", flip " << i;
    }
  }
}

}  // namespace
}  // namespace kiln::test
