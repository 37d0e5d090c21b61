// Source: H5checksum.c of HDF5 (Fletcher-32), liblzf's lzf_d.c, the HDF5 LZ4 filter's H5Zlz4.c, and bitshuffle's
// bshuf_h5filter.c.
#include "ingest/codec/hdf5_codecs.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>

#include "ingest/codec/block_codecs.h"
#include "ingest/codec/byte_shuffle.h"

namespace kiln {
namespace {

std::uint64_t grownByBlocks(std::uint64_t bytes) { return bytes + bytes / 8 + (64 << 10); }

/// Takes big-endian numbers and bytes from the front of a sequence.
struct Taker {
  std::span<const std::byte> left;

  template <class T>
  std::optional<T> number() {
    if (left.size() < sizeof(T)) return std::nullopt;
    T out = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) out = static_cast<T>(out << 8 | std::to_integer<T>(left[i]));
    left = left.subspan(sizeof(T));
    return out;
  }
  std::optional<std::span<const std::byte>> bytes(std::uint64_t count) {
    if (left.size() < count) return std::nullopt;
    const std::span<const std::byte> out = left.first(count);
    left = left.subspan(count);
    return out;
  }
};

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

class Fletcher32Codec : public ByteCodec {
 public:
  std::size_t decode(std::span<const std::byte> packed, std::span<std::byte> out,
                     const ChunkPlace& place) const override {
    constexpr std::size_t kBytes = sizeof(std::uint32_t);
    if (packed.size() < kBytes || packed.size() - kBytes > out.size())
      place.fail(fmt::format("{} bytes with their checksum are too many or too few", packed.size()));
    const std::span<const std::byte> data = packed.first(packed.size() - kBytes);
    std::uint32_t expected;
    std::memcpy(&expected, packed.data() + data.size(), kBytes);
    const std::uint32_t found = fletcher32(data);
    // Early versions of the library swapped the bytes of each half.
    const std::uint32_t swapped = (found & 0x00ff00ff) << 8 | (found >> 8 & 0x00ff00ff);
    if (found != expected && swapped != expected)
      place.fail("the checksum (Fletcher-32) differs: the chunk is damaged");
    if (!data.empty()) std::memcpy(out.data(), data.data(), data.size());
    return data.size();
  }
  std::uint64_t packedBytes(std::uint64_t bytes) const override { return bytes + sizeof(std::uint32_t); }
};

// A control byte below 32 precedes that many literal bytes and one; any other begins a copy of earlier bytes: three
// bits of length, 13 bits of distance.
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
  Taker taker{packed};
  const auto total = taker.number<std::uint64_t>();
  const auto block_bytes = taker.number<std::uint32_t>();
  if (!block_bytes || *total > out.size() || (*block_bytes == 0 && *total > 0)) return std::nullopt;
  std::size_t done = 0;
  while (done < *total) {
    const std::size_t bytes = std::min<std::uint64_t>(*block_bytes, *total - done);
    const auto size = taker.number<std::uint32_t>();
    const auto block = size ? taker.bytes(*size) : std::nullopt;
    if (!block) return std::nullopt;
    if (block->size() == bytes)
      std::memcpy(&out[done], block->data(), bytes);
    else if (unpackLz4(*block, out.subspan(done, bytes)) != bytes)
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
    Taker taker{packed};
    std::uint64_t total = packed.size();
    std::size_t block = block_;
    if (inner_ != BitshuffleInner::kNone) {
      const auto bytes = taker.number<std::uint64_t>();
      const auto block_bytes = taker.number<std::uint32_t>();
      if (!block_bytes) return std::nullopt;
      total = *bytes;
      if (*block_bytes != 0) block = *block_bytes / size_;
      if (block == 0 || block % 8 != 0) return std::nullopt;
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
    const auto rest = taker.bytes(total - done);
    if (!rest) return std::nullopt;
    if (!rest->empty()) std::memcpy(&out[done], rest->data(), rest->size());
    return total;
  }

 private:
  bool unpackPlanes(Taker& taker, std::span<std::byte> to) const {
    if (inner_ == BitshuffleInner::kNone) {
      const auto kept = taker.bytes(to.size());
      if (kept) std::copy(kept->begin(), kept->end(), to.begin());
      return kept.has_value();
    }
    const auto size = taker.number<std::uint32_t>();
    const auto packed = size ? taker.bytes(*size) : std::nullopt;
    if (!packed) return false;
    return (inner_ == BitshuffleInner::kLz4 ? unpackLz4(*packed, to) : unpackZstd(*packed, to)) == to.size();
  }

  std::size_t size_, block_;
  BitshuffleInner inner_;
};

/// A filter given by its function.
template <class Unpack>
class UnpackCodec : public ByteCodec {
 public:
  UnpackCodec(const char* name, Unpack unpack) : name_(name), unpack_(unpack) {}
  std::size_t decode(std::span<const std::byte> packed, std::span<std::byte> out,
                     const ChunkPlace& place) const override {
    const std::optional<std::size_t> bytes = unpack_(packed, out);
    if (!bytes) place.fail(fmt::format("the {} data are damaged or too long (room for {} bytes)", name_, out.size()));
    return *bytes;
  }
  std::uint64_t packedBytes(std::uint64_t bytes) const override { return grownByBlocks(bytes); }

 private:
  const char* name_;
  Unpack unpack_;
};

template <class Unpack>
std::unique_ptr<ByteCodec> unpackCodec(const char* name, Unpack unpack) {
  return std::make_unique<UnpackCodec<Unpack>>(name, unpack);
}

}  // namespace

std::unique_ptr<ByteCodec> fletcher32Codec() { return std::make_unique<Fletcher32Codec>(); }
std::unique_ptr<ByteCodec> lzfCodec() { return unpackCodec("LZF", &unpackLzf); }
std::unique_ptr<ByteCodec> hdf5Lz4Codec() { return unpackCodec("LZ4", &unpackHdf5Lz4); }
std::unique_ptr<ByteCodec> bitshuffleCodec(std::size_t number_bytes, std::size_t block, BitshuffleInner inner) {
  return unpackCodec("bitshuffle", Bitshuffle(number_bytes, block, inner));
}

}  // namespace kiln
