// Codecs given by a function: a decompressor, or a checksum behind the data. Internal, not installed.
#pragma once

#include <fmt/format.h>

#include <cstring>
#include <optional>
#include <utility>

#include "ingest/codec/byte_codec.h"

namespace kiln {

/// Bound for the growth of data that do not compress, with headers and checksums, for every compressor here.
constexpr std::uint64_t grownBytes(std::uint64_t bytes) { return bytes + bytes / 8 + (64 << 10); }

inline std::string roomText(std::span<const std::byte> out) { return fmt::format("(room for {} bytes)", out.size()); }

/// Decodes by `unpack(packed, out)`, which returns the number of bytes written, or nothing for damaged data.
/// `scratch_bytes` is the memory of `unpack`.
template <class Unpack>
class UnpackCodec : public ByteCodec {
 public:
  UnpackCodec(const char* name, Unpack unpack, std::uint64_t scratch_bytes = 0)
      : name_(name), unpack_(std::move(unpack)), scratch_bytes_(scratch_bytes) {}
  std::size_t decode(std::span<const std::byte> packed, std::span<std::byte> out,
                     const ChunkPlace& place) const override {
    const std::optional<std::size_t> bytes = unpack_(packed, out);
    if (!bytes) place.fail(fmt::format("the {} data are damaged or too long {}", name_, roomText(out)));
    return *bytes;
  }
  std::uint64_t packedBytes(std::uint64_t bytes) const override { return grownBytes(bytes); }
  std::uint64_t scratchBytes(std::uint64_t) const override { return scratch_bytes_; }

 private:
  const char* name_;
  Unpack unpack_;
  std::uint64_t scratch_bytes_;
};

template <class Unpack>
std::unique_ptr<ByteCodec> unpackCodec(const char* name, Unpack unpack, std::uint64_t scratch_bytes = 0) {
  return std::make_unique<UnpackCodec<Unpack>>(name, std::move(unpack), scratch_bytes);
}

/// Four bytes behind the data, which `matches(data, checksum)` tests.
template <class Matches>
class ChecksumCodec : public ByteCodec {
 public:
  ChecksumCodec(const char* name, Matches matches) : name_(name), matches_(std::move(matches)) {}
  std::size_t decode(std::span<const std::byte> packed, std::span<std::byte> out,
                     const ChunkPlace& place) const override {
    if (packed.size() < kBytes || packed.size() - kBytes > out.size())
      place.fail(fmt::format("{} bytes with their checksum have a wrong length {}", packed.size(), roomText(out)));
    const std::span<const std::byte> data = packed.first(packed.size() - kBytes);
    std::uint32_t checksum;
    std::memcpy(&checksum, packed.data() + data.size(), kBytes);
    if (!matches_(data, checksum)) place.fail(fmt::format("the checksum ({}) differs: the chunk is damaged", name_));
    if (!data.empty()) std::memcpy(out.data(), data.data(), data.size());
    return data.size();
  }
  std::uint64_t packedBytes(std::uint64_t bytes) const override { return bytes + kBytes; }

 private:
  static constexpr std::size_t kBytes = sizeof(std::uint32_t);
  const char* name_;
  Matches matches_;
};

template <class Matches>
std::unique_ptr<ByteCodec> checksumCodec(const char* name, Matches matches) {
  return std::make_unique<ChecksumCodec<Matches>>(name, std::move(matches));
}

}  // namespace kiln
