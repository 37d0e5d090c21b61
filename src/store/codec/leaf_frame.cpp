#include "store/codec/leaf_frame.h"

#include <lz4.h>

#include <algorithm>

#include "base/blosc_head.h"

namespace kiln {
namespace {

static_assert(sizeof(BloscHead) == kFrameOverhead_bytes);
using BlockOffset = std::uint32_t;
using PackedLength = std::uint32_t;  // before each compressed piece
constexpr std::size_t kOneBlockAt = sizeof(BloscHead) + sizeof(BlockOffset) + sizeof(PackedLength);

constexpr std::uint8_t kOtherOrders = 3 << 2;
// Flags of the frames that packLeaf writes.
constexpr std::uint8_t kWritten =
    BloscHead::kBytePlanes | BloscHead::kNotSplit | BloscHead::flagOf(BloscHead::Codec::kLz4);
// Blosc's acceleration at level 9, OpenVDB's.
constexpr int kAcceleration = 1;

BloscHead headOf(std::span<const std::byte> frame) {
  BloscHead head;
  std::memcpy(&head, frame.data(), sizeof head);
  return head;
}

template <class T>
T numberAt(std::span<const std::byte> from, std::size_t at) {
  T out;
  std::memcpy(&out, from.data() + at, sizeof out);
  return out;
}

template <class T>
void putAt(T number, std::byte* at) {
  std::memcpy(at, &number, sizeof number);
}

// Puts the first bytes of all numbers in front, then the second bytes, and so on; bytes of no whole number are last.
KILN_VECTORS void splitPlanes(const std::byte* __restrict values, std::size_t bytes, std::uint8_t* __restrict planes) {
  const std::size_t n = bytes / kBloscTypeBytes;
  for (std::size_t plane = 0; plane < kBloscTypeBytes; ++plane) {
    for (std::size_t i = 0; i < n; ++i) {
      std::uint32_t number;
      std::memcpy(&number, values + kBloscTypeBytes * i, sizeof number);
      planes[plane * n + i] = static_cast<std::uint8_t>(number >> 8 * plane);
    }
  }
  std::memcpy(planes + kBloscTypeBytes * n, values + kBloscTypeBytes * n, bytes - kBloscTypeBytes * n);
}

// The reverse of splitPlanes for numbers of any size.
void joinBytes(const std::uint8_t* planes, std::size_t bytes, std::size_t type_bytes, std::byte* values) {
  const std::size_t n = bytes / type_bytes;
  for (std::size_t plane = 0; plane < type_bytes; ++plane) {
    for (std::size_t i = 0; i < n; ++i) values[type_bytes * i + plane] = static_cast<std::byte>(planes[plane * n + i]);
  }
  std::memcpy(values + type_bytes * n, planes + type_bytes * n, bytes - type_bytes * n);
}

// Compresses all blocks into `out`, which has room for the overhead. Returns the length of the frame; 0 if it would be
// longer than uncompressed.
std::size_t packBlocks(const BloscHead& head, const std::byte* values, std::byte* out) {
  alignas(64) std::uint8_t planes[kMostLeafBytes];
  const std::size_t room = head.bytes + kFrameOverhead_bytes;
  std::size_t at = sizeof head + head.blocks() * sizeof(BlockOffset);
  for (std::size_t block = 0; block < head.blocks(); ++block) {
    const std::size_t first = block * head.block_bytes,
                      bytes = std::min<std::size_t>(head.block_bytes, head.bytes - first);
    splitPlanes(values + first, bytes, planes);
    putAt(static_cast<BlockOffset>(at), out + sizeof head + block * sizeof(BlockOffset));
    const std::size_t length_at = at;
    at += sizeof(PackedLength);
    if (at >= room) return 0;
    std::size_t packed = static_cast<std::size_t>(
        LZ4_compress_fast(reinterpret_cast<const char*>(planes), reinterpret_cast<char*>(out + at),
                          static_cast<int>(bytes), static_cast<int>(std::min(bytes, room - at)), kAcceleration));
    // A piece as long as its bytes is uncompressed.
    if (packed == 0 || packed == bytes) {
      if (at + bytes > room) return 0;
      std::memcpy(out + at, planes, bytes);
      packed = bytes;
    }
    putAt(static_cast<PackedLength>(packed), out + length_at);
    at += packed;
  }
  return at;
}

// Decompresses the pieces of one block from offset `at`. Returns false if the frame is damaged.
bool unpackPieces(std::span<const std::byte> frame, std::size_t at, std::size_t pieces, std::size_t bytes,
                  std::uint8_t* planes) {
  const std::size_t of_piece = bytes / pieces;
  for (std::size_t piece = 0; piece < pieces; ++piece, planes += of_piece) {
    if (at > frame.size() || frame.size() - at < sizeof(PackedLength)) return false;
    const std::size_t packed = numberAt<PackedLength>(frame, at);
    at += sizeof(PackedLength);
    if (packed > frame.size() - at) return false;
    if (packed == of_piece) {
      std::memcpy(planes, frame.data() + at, packed);
    } else {
      const int unpacked =
          LZ4_decompress_safe(reinterpret_cast<const char*>(frame.data() + at), reinterpret_cast<char*>(planes),
                              static_cast<int>(packed), static_cast<int>(of_piece));
      if (unpacked < 0 || static_cast<std::size_t>(unpacked) != of_piece) return false;
    }
    at += packed;
  }
  return true;
}

}  // namespace

std::size_t packLeaf(const void* values, std::size_t bytes, std::byte* out) noexcept {
  const auto* const from = static_cast<const std::byte*>(values);
  // A block is a multiple of a number; the bytes of no whole number are a block of their own.
  const std::size_t whole = bytes / kBloscTypeBytes * kBloscTypeBytes;
  BloscHead head{BloscHead::kVersion,
                 BloscHead::kCodecVersion,
                 kWritten,
                 kBloscTypeBytes,
                 static_cast<std::uint32_t>(bytes),
                 static_cast<std::uint32_t>(std::max<std::size_t>(whole, 1)),
                 0};
  std::size_t length = bytes < BloscHead::kFewestBytes ? 0 : packBlocks(head, from, out);
  if (length == 0) {
    head.flags |= BloscHead::kKept;
    std::memcpy(out + sizeof head, from, bytes);
    length = sizeof head + bytes;
  }
  head.frame_bytes = static_cast<std::uint32_t>(length);
  putAt(head, out);
  return length;
}

bool isLeafFrame(std::span<const std::byte> frame, std::size_t bytes) noexcept {
  if (frame.size() < sizeof(BloscHead)) return false;
  const BloscHead head = headOf(frame);
  if (head.version != BloscHead::kVersion || head.bytes != bytes || head.frame_bytes != frame.size()) return false;
  if (head.has(BloscHead::kKept)) return frame.size() == sizeof head + bytes;
  return head.codec_version == BloscHead::kCodecVersion && head.codec() == BloscHead::Codec::kLz4 &&
         (head.flags & kOtherOrders) == 0 && head.number_bytes > 0 && head.block_bytes > 0 &&
         head.block_bytes <= bytes && head.blocks() <= (frame.size() - sizeof head) / sizeof(BlockOffset);
}

bool isPlainFrame(std::span<const std::byte> frame, std::size_t bytes) noexcept {
  const BloscHead head = headOf(frame);
  if (head.has(BloscHead::kKept)) return true;
  return head.flags == kWritten && head.number_bytes == kBloscTypeBytes && head.block_bytes == bytes &&
         bytes % kBloscTypeBytes == 0 && frame.size() >= kOneBlockAt &&
         numberAt<BlockOffset>(frame, sizeof head) == sizeof head + sizeof(BlockOffset) &&
         numberAt<PackedLength>(frame, sizeof head + sizeof(BlockOffset)) == frame.size() - kOneBlockAt &&
         frame.size() - kOneBlockAt < bytes;
}

const std::byte* keptValues(std::span<const std::byte> frame) noexcept {
  const auto flags = std::to_integer<unsigned>(frame[offsetof(BloscHead, flags)]);
  return (flags & BloscHead::kKept) != 0 ? frame.data() + sizeof(BloscHead) : nullptr;
}

bool unpackPlanes(std::span<const std::byte> frame, std::size_t bytes, std::size_t wanted,
                  std::uint8_t* planes) noexcept {
  const std::span<const std::byte> packed = frame.subspan(kOneBlockAt);
  const auto* const from = reinterpret_cast<const char*>(packed.data());
  auto* const to = reinterpret_cast<char*>(planes);
  const auto size = static_cast<int>(packed.size()), capacity = static_cast<int>(bytes);
  // LZ4 copies the end of a partial block byte by byte. Partial decompression pays for one byte in four, not for two.
  const int unpacked = wanted <= bytes / kBloscTypeBytes
                           ? LZ4_decompress_safe_partial(from, to, size, static_cast<int>(wanted), capacity)
                           : LZ4_decompress_safe(from, to, size, capacity);
  return unpacked >= 0 && static_cast<std::size_t>(unpacked) >= wanted;
}

bool unpackBlocks(std::span<const std::byte> frame, std::size_t bytes, std::byte* values) noexcept {
  const BloscHead head = headOf(frame);
  alignas(64) std::uint8_t planes[kMostLeafBytes];
  for (std::size_t block = 0; block < head.blocks(); ++block) {
    const std::size_t first = block * head.block_bytes;
    const std::size_t of_block = std::min<std::size_t>(head.block_bytes, bytes - first);
    const std::size_t pieces = head.pieces(of_block);
    const auto at = numberAt<BlockOffset>(frame, sizeof head + block * sizeof(BlockOffset));
    if (of_block % pieces != 0 || !unpackPieces(frame, at, pieces, of_block, planes)) return false;
    joinBytes(planes, of_block, head.has(BloscHead::kBytePlanes) ? head.number_bytes : 1, values + first);
  }
  return true;
}

}  // namespace kiln
