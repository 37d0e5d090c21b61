// A frame of one block that is not split: all byte planes are one Zstandard frame, so that equal upper bytes of numbers
// become long matches. The reader is ingest/codec/blosc_frame.cpp.
#include "export/zarr/blosc_pack.h"

#include <zstd.h>

#include <memory>
#include <new>

#include "base/blosc_head.h"
#include "base/byte_record.h"
#include "ingest/codec/byte_shuffle.h"

namespace kiln {
namespace {

constexpr std::uint8_t kFlags = BloscHead::kNotSplit | BloscHead::flagOf(BloscHead::Codec::kZstd);
constexpr std::size_t kHeadBytes = sizeof(BloscHead), kBlockHeadBytes = 2 * sizeof(std::uint32_t);

struct FreeCompression {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
};

ZSTD_CCtx* compressionOfThread() {
  thread_local std::unique_ptr<ZSTD_CCtx, FreeCompression> context(ZSTD_createCCtx());
  if (!context) context.reset(ZSTD_createCCtx());
  if (!context) throw std::bad_alloc();
  return context.get();
}

std::vector<std::byte> frameHead(unsigned flags, std::size_t number_bytes, std::size_t bytes, std::size_t frame) {
  std::vector<std::byte> out;
  out.reserve(frame);
  appendValue(out, BloscHead{BloscHead::kVersion, BloscHead::kCodecVersion, static_cast<std::uint8_t>(kFlags | flags),
                             static_cast<std::uint8_t>(number_bytes), static_cast<std::uint32_t>(bytes),
                             static_cast<std::uint32_t>(bytes), static_cast<std::uint32_t>(frame)});
  return out;
}

// Incompressible numbers stay as they are.
std::vector<std::byte> storedFrame(std::span<const std::byte> numbers, std::size_t number_bytes) {
  std::vector<std::byte> out = frameHead(BloscHead::kKept, number_bytes, numbers.size(), kHeadBytes + numbers.size());
  out.insert(out.end(), numbers.begin(), numbers.end());
  return out;
}

}  // namespace

std::uint64_t packedBloscBytes(std::uint64_t bytes) { return kHeadBytes + bytes; }

std::uint64_t bloscWorkBytes(std::uint64_t bytes) {
  // The context, measured by ZSTD_sizeof_CCtx for blocks of 512 KiB and more.
  constexpr std::uint64_t kContext = 4 << 20;
  return kContext + bytes + ZSTD_compressBound(bytes) + packedBloscBytes(bytes);
}

std::vector<std::byte> packBlosc(std::span<const std::byte> numbers, std::size_t number_bytes) {
  std::vector<std::byte> planes(number_bytes > 1 ? numbers.size() : 0);
  if (number_bytes > 1) splitBytePlanes(numbers, number_bytes, planes.data());
  const std::span<const std::byte> block = number_bytes > 1 ? std::span<const std::byte>(planes) : numbers;
  std::vector<std::byte> packed(ZSTD_compressBound(block.size()));
  const std::size_t bytes =
      ZSTD_compressCCtx(compressionOfThread(), packed.data(), packed.size(), block.data(), block.size(), kBloscLevel);
  if (ZSTD_isError(bytes)) throw std::bad_alloc();  // the only failure: the room is sufficient
  const std::size_t frame = kHeadBytes + kBlockHeadBytes + bytes;
  if (bytes >= block.size() || frame >= packedBloscBytes(numbers.size())) return storedFrame(numbers, number_bytes);
  std::vector<std::byte> out =
      frameHead(number_bytes > 1 ? unsigned{BloscHead::kBytePlanes} : 0, number_bytes, numbers.size(), frame);
  appendValue(out, static_cast<std::uint32_t>(kHeadBytes + sizeof(std::uint32_t)));  // the place of the block
  appendValue(out, static_cast<std::uint32_t>(bytes));
  out.insert(out.end(), packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(bytes));
  return out;
}

}  // namespace kiln
