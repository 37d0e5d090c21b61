// Source: H5checksum.c of HDF5 (Fletcher-32), liblzf's lzf_d.c, the HDF5 LZ4 filter's H5Zlz4.c, and bitshuffle's
// bshuf_h5filter.c.
#include "ingest/codec/hdf5_codecs.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <vector>

#include "base/byte_record.h"
#include "ingest/codec/block_codecs.h"
#include "ingest/codec/byte_shuffle.h"
#include "ingest/codec/unpack_codec.h"

namespace kiln {
namespace {

// Sums 16-bit words, the first byte high; a last odd byte is the high byte of a word.
std::uint32_t fletcher32(std::span<const std::byte> data) {
  const auto folded = [](std::uint32_t sum) { return (sum & 0xffff) + (sum >> 16); };
  std::uint32_t first = 0, second = 0;
  std::size_t at = 0;
  while (at + 1 < data.size()) {
    // 360 words fit before a sum can overflow.
    const std::size_t end = std::min(at + 720, data.size() & ~std::size_t{1});
    for (; at < end; at += 2) {
      first += std::to_integer<std::uint32_t>(data[at]) << 8 | std::to_integer<std::uint32_t>(data[at + 1]);
      second += first;
    }
    first = folded(first);
    second = folded(second);
  }
  if (at < data.size()) {
    first += std::to_integer<std::uint32_t>(data[at]) << 8;
    second += first;
    first = folded(first);
    second = folded(second);
  }
  return folded(second) << 16 | folded(first);
}

bool matchesFletcher32(std::span<const std::byte> data, std::uint32_t checksum) {
  const std::uint32_t found = fletcher32(data);
  // Early versions of the library swapped the bytes of each half.
  const std::uint32_t swapped = (found & 0x00ff00ff) << 8 | (found >> 8 & 0x00ff00ff);
  return found == checksum || swapped == checksum;
}

// A control byte N below 32 precedes N + 1 literal bytes. A larger control byte begins a copy of earlier bytes, with
// three bits of length and 13 bits of distance.
std::optional<std::size_t> unpackLzf(std::span<const std::byte> in, std::span<std::byte> out) {
  std::size_t at = 0, done = 0;
  const auto next = [&] { return std::to_integer<std::size_t>(in[at++]); };
  while (at < in.size()) {
    const std::size_t control = next();
    if (control < 32) {
      const std::size_t count = control + 1;
      if (count > in.size() - at || count > out.size() - done) return std::nullopt;
      std::memcpy(&out[done], &in[at], count);
      at += count;
      done += count;
      continue;
    }
    std::size_t length = control >> 5;
    if (length == 7) {
      if (at >= in.size()) return std::nullopt;
      length += next();
    }
    if (at >= in.size()) return std::nullopt;
    const std::size_t distance = ((control & 31) << 8 | next()) + 1;
    length += 2;
    if (distance > done || length > out.size() - done) return std::nullopt;
    for (std::size_t i = 0; i < length; ++i, ++done) out[done] = out[done - distance];
  }
  return done;
}

std::optional<std::size_t> unpackHdf5Lz4(std::span<const std::byte> packed, std::span<std::byte> out) {
  ByteTaker taker{packed};
  const auto total = taker.takeBigEndian<std::uint64_t>();
  const auto block_bytes = taker.takeBigEndian<std::uint32_t>();
  if (!taker.ok || total > out.size() || (block_bytes == 0 && total > 0)) return std::nullopt;
  std::size_t done = 0;
  while (done < total) {
    const std::size_t bytes = std::min<std::uint64_t>(block_bytes, total - done);
    const std::span<const std::byte> block = taker.takeBytes(taker.takeBigEndian<std::uint32_t>());
    if (!taker.ok) return std::nullopt;
    if (block.size() == bytes)
      std::memcpy(&out[done], block.data(), bytes);
    else if (unpackLz4(block, out.subspan(done, bytes)) != bytes)
      return std::nullopt;
    done += bytes;
  }
  return done;
}

class Bitshuffle {
 public:
  Bitshuffle(std::size_t number_bytes, std::size_t block, BitshuffleInner inner)
      : size_(number_bytes),
        block_(block != 0 ? block : std::max<std::size_t>(8192 / number_bytes / 8 * 8, 128)),
        inner_(inner) {}

  std::optional<std::size_t> operator()(std::span<const std::byte> packed, std::span<std::byte> out) const {
    ByteTaker taker{packed};
    std::uint64_t total = packed.size();
    std::size_t block = block_;
    if (inner_ != BitshuffleInner::kNone) {
      total = taker.takeBigEndian<std::uint64_t>();
      const auto block_bytes = taker.takeBigEndian<std::uint32_t>();
      if (block_bytes != 0) block = block_bytes / size_;
      if (!taker.ok || block == 0 || block % 8 != 0) return std::nullopt;
    }
    if (total > out.size() || total % size_ != 0) return std::nullopt;
    std::vector<std::byte> planes(std::min<std::uint64_t>(block * size_, total));
    std::size_t done = 0;
    // The last block has a multiple of eight numbers; the numbers behind it are kept as they are.
    while (total - done >= 8 * size_) {
      const std::size_t numbers = std::min<std::uint64_t>(block, (total - done) / size_ / 8 * 8),
                        bytes = numbers * size_;
      const std::span<std::byte> to = std::span(planes).first(bytes);
      if (!unpackPlanes(taker, to)) return std::nullopt;
      joinBitPlanes(to, size_, &out[done]);
      done += bytes;
    }
    const std::span<const std::byte> rest = taker.takeBytes(total - done);
    if (!taker.ok) return std::nullopt;
    if (!rest.empty()) std::memcpy(&out[done], rest.data(), rest.size());
    return total;
  }

 private:
  bool unpackPlanes(ByteTaker& taker, std::span<std::byte> to) const {
    const bool kept = inner_ == BitshuffleInner::kNone;
    const std::span<const std::byte> packed = taker.takeBytes(kept ? to.size() : taker.takeBigEndian<std::uint32_t>());
    if (!taker.ok) return false;
    if (kept) {
      std::copy(packed.begin(), packed.end(), to.begin());
      return true;
    }
    return (inner_ == BitshuffleInner::kLz4 ? unpackLz4(packed, to) : unpackZstd(packed, to)) == to.size();
  }

  std::size_t size_, block_;
  BitshuffleInner inner_;
};

class BitshuffleCodec : public UnpackCodec<Bitshuffle> {
 public:
  using UnpackCodec::UnpackCodec;
  // A block before its planes are joined, at most the whole chunk.
  std::uint64_t scratchBytes(std::uint64_t bytes) const override { return bytes; }
};

}  // namespace

std::unique_ptr<ByteCodec> fletcher32Codec() { return checksumCodec("Fletcher-32", &matchesFletcher32); }
std::unique_ptr<ByteCodec> lzfCodec() { return unpackCodec("LZF", &unpackLzf); }
std::unique_ptr<ByteCodec> hdf5Lz4Codec() { return unpackCodec("LZ4", &unpackHdf5Lz4); }
std::unique_ptr<ByteCodec> bitshuffleCodec(std::size_t number_bytes, std::size_t block, BitshuffleInner inner) {
  return std::make_unique<BitshuffleCodec>("bitshuffle", Bitshuffle(number_bytes, block, inner));
}

}  // namespace kiln
