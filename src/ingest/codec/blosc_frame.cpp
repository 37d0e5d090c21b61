// Problem. Frames come from strangers, and Blosc's own reader trusts lengths inside its blocks.
// Method. Walks the frame here, tests each length, and gives every piece to the decompressor of its codec, which has
// its own bounds. Invariant: no byte is read beyond the frame or written beyond its stated size, which fits into the
// output. Source: README_CHUNK_FORMAT of c-blosc 1.21.
#include "ingest/codec/blosc_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "base/blosc_head.h"
#include "base/byte_record.h"
#include "ingest/codec/block_codecs.h"
#include "ingest/codec/byte_shuffle.h"

namespace kiln {
namespace {

using Codec = BloscHead::Codec;

std::optional<std::size_t> unpackPiece(Codec codec, std::span<const std::byte> packed, std::span<std::byte> out) {
  switch (codec) {
    case Codec::kLz4:
      return unpackLz4(packed, out);
    case Codec::kZlib:
      return unpackDeflate(packed, DeflateWrapper::kZlib, out);
    case Codec::kZstd:
      return unpackZstd(packed, out);
    case Codec::kBloscLz:
      return unpackBloscLz(packed, out);
    case Codec::kSnappy:
      break;
  }
  return std::nullopt;
}

// Restores the order of the bytes of one block.
void joinPlanes(const BloscHead& head, std::span<const std::byte> block, std::byte* out) noexcept {
  const std::size_t size = head.number_bytes;
  if (head.has(BloscHead::kBytePlanes) && size > 1) return joinBytePlanes(block, size, out);
  // A block whose numbers are no multiple of eight stays as it is; bytes behind the last number always do.
  const std::size_t count = block.size() / size, shuffled = count % 8 == 0 ? count * size : 0;
  joinBitPlanes(block.first(shuffled), size, out);
  std::memcpy(out + shuffled, block.data() + shuffled, block.size() - shuffled);
}

class FrameReader {
 public:
  FrameReader(const BloscHead& head, std::span<const std::byte> frame)
      : head_(head), frame_(frame), codec_(head.codec()) {
    const bool shuffles = head.has(BloscHead::kBytePlanes) && head.number_bytes > 1;
    planes_ = shuffles || (head.has(BloscHead::kBitPlanes) && head.block_bytes >= head.number_bytes);
  }

  std::string unpack(std::span<std::byte> out) {
    if (codec_ == Codec::kSnappy) return "Snappy inside Blosc is not read; write it with lz4, zstd or zlib";
    if (codec_ > Codec::kZstd) return fmt::format("codec {} inside Blosc is unknown", head_.flags >> 5);
    if (planes_) shuffled_.resize(std::min<std::size_t>(head_.block_bytes, out.size()));
    for (std::size_t at = 0, block = 0; at < out.size(); at += head_.block_bytes, ++block) {
      const std::span<std::byte> to = out.subspan(at, std::min<std::size_t>(head_.block_bytes, out.size() - at));
      if (!unpackBlock(block, to)) return fmt::format("block {} of the Blosc frame is damaged", block);
    }
    return {};
  }

 private:
  bool unpackBlock(std::size_t block, std::span<std::byte> out) {
    ByteTaker offset{frame_.subspan(sizeof(BloscHead) + block * sizeof(std::uint32_t))};
    const auto begin = offset.take<std::uint32_t>();
    if (!offset.ok || begin > frame_.size()) return false;
    const std::span<std::byte> raw = planes_ ? std::span(shuffled_).first(out.size()) : out;
    ByteTaker pieces{frame_.subspan(begin)};
    const std::size_t count = head_.pieces(out.size()), piece_bytes = out.size() / count;
    if (piece_bytes * count != out.size()) return false;
    for (std::size_t i = 0; i < count; ++i) {
      const std::span<const std::byte> packed = pieces.takeBytes(pieces.take<std::uint32_t>());
      const std::span<std::byte> to = raw.subspan(i * piece_bytes, piece_bytes);
      if (!pieces.ok) return false;
      if (packed.size() == piece_bytes)
        std::memcpy(to.data(), packed.data(), piece_bytes);
      else if (unpackPiece(codec_, packed, to) != piece_bytes)
        return false;
    }
    if (planes_) joinPlanes(head_, raw, out.data());
    return true;
  }

  BloscHead head_;
  std::span<const std::byte> frame_;
  Codec codec_;
  bool planes_ = false;
  std::vector<std::byte> shuffled_;
};

}  // namespace

std::string unpackBlosc(std::span<const std::byte> frame, std::span<std::byte> out, std::size_t& written) {
  BloscHead head;
  if (frame.size() < sizeof head) return fmt::format("a Blosc frame of {} bytes is cut", frame.size());
  std::memcpy(&head, frame.data(), sizeof head);
  if (head.version != 1 && head.version != 2) return fmt::format("version {} of Blosc is unknown", head.version);
  if (head.frame_bytes != frame.size())
    return fmt::format("a Blosc frame of {} bytes says that it has {}", frame.size(), head.frame_bytes);
  if (head.bytes > out.size())
    return fmt::format("the Blosc frame holds {} bytes (room for {})", head.bytes, out.size());
  if (head.number_bytes == 0) return "the Blosc frame has numbers of 0 bytes";
  written = head.bytes;
  if (head.bytes == 0) return {};
  if (head.has(BloscHead::kKept)) {
    if (frame.size() != sizeof head + head.bytes) return "the Blosc frame has a wrong length";
    std::memcpy(out.data(), frame.data() + sizeof head, head.bytes);
    return {};
  }
  if (head.block_bytes == 0) return "the Blosc frame has blocks of 0 bytes";
  if (frame.size() - sizeof head < head.blocks() * sizeof(std::uint32_t))
    return "the Blosc frame is shorter than its table of blocks";
  return FrameReader(head, frame).unpack(out.first(head.bytes));
}

}  // namespace kiln
