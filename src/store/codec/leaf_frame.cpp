#include "store/codec/leaf_frame.h"

#include <lz4.h>

namespace kiln {
namespace {

// Blosc's header, little-endian.
struct FrameHead {
  std::uint8_t version, of_codec, flags, type_bytes;
  std::uint32_t bytes, block_bytes, frame_bytes;
};
static_assert(sizeof(FrameHead) == 16);
// Offset of the only block, and the length of the block.
struct BlockHead {
  std::uint32_t at, packed_bytes;
};
constexpr std::size_t kBlockAt = sizeof(FrameHead) + sizeof(BlockHead);

constexpr std::uint8_t kVersion = 2, kOfLz4 = 1;
constexpr std::uint8_t kShuffled = 1, kKept = 1 << 1, kNotSplit = 1 << 4, kLz4 = 1 << 5;

}  // namespace

bool isLeafFrame(std::span<const std::byte> frame, std::size_t bytes) noexcept {
  FrameHead head;
  if (frame.size() < sizeof head || bytes % kBloscTypeBytes != 0) return false;
  std::memcpy(&head, frame.data(), sizeof head);
  if (head.version != kVersion || head.bytes != bytes || head.frame_bytes != frame.size()) return false;
  if ((head.flags & kKept) != 0) return frame.size() == sizeof head + bytes;
  BlockHead block;
  if (frame.size() < kBlockAt) return false;
  std::memcpy(&block, frame.data() + sizeof head, sizeof block);
  return head.of_codec == kOfLz4 && head.flags == (kShuffled | kNotSplit | kLz4) &&
         head.type_bytes == kBloscTypeBytes && head.block_bytes == bytes && block.at == sizeof head + sizeof block.at &&
         block.packed_bytes == frame.size() - kBlockAt && block.packed_bytes < bytes;
}

const std::byte* keptValues(std::span<const std::byte> frame) noexcept {
  const auto flags = std::to_integer<unsigned>(frame[offsetof(FrameHead, flags)]);
  return (flags & kKept) != 0 ? frame.data() + sizeof(FrameHead) : nullptr;
}

bool unpackPlanes(std::span<const std::byte> frame, std::size_t bytes, std::size_t wanted,
                  std::uint8_t* planes) noexcept {
  const std::span<const std::byte> packed = frame.subspan(kBlockAt);
  const auto* const from = reinterpret_cast<const char*>(packed.data());
  auto* const to = reinterpret_cast<char*>(planes);
  const auto size = static_cast<int>(packed.size()), capacity = static_cast<int>(bytes);
  // LZ4 copies the end of a partial block byte by byte. Partial decompression pays for one byte in four, not for two.
  const int unpacked = wanted <= bytes / kBloscTypeBytes
                           ? LZ4_decompress_safe_partial(from, to, size, static_cast<int>(wanted), capacity)
                           : LZ4_decompress_safe(from, to, size, capacity);
  return unpacked >= 0 && static_cast<std::size_t>(unpacked) >= wanted;
}

}  // namespace kiln
