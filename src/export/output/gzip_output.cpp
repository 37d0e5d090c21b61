// Method. Each block is deflated alone and ends at a byte (Z_SYNC_FLUSH), so blocks follow each other in one stream.
// The window before a block is its dictionary, so hardly any compression is lost. Source: pigz by Mark Adler; RFC 1951,
// 1952.
#include "export/output/gzip_output.h"

#include <zlib.h>

#include <algorithm>
#include <new>
#include <utility>

#include "base/byte_record.h"
#include "base/thread/parallel.h"

namespace kiln {
namespace {

constexpr std::size_t kBlock = 512 << 10, kWindow = 32 << 10;
// On a phantom of CT as small as level 6, in a third of the time.
constexpr int kGzipLevel = 4;

std::vector<std::byte> deflatedBlock(std::span<const std::byte> dictionary, std::span<const std::byte> block) {
  z_stream stream{};
  constexpr int kRawWindow = -15, kMemory = 8;
  if (deflateInit2(&stream, kGzipLevel, Z_DEFLATED, kRawWindow, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  const auto bytesAt = [](std::span<const std::byte> data) {
    return const_cast<Bytef*>(reinterpret_cast<const Bytef*>(data.data()));
  };
  if (!dictionary.empty()) deflateSetDictionary(&stream, bytesAt(dictionary), static_cast<uInt>(dictionary.size()));
  constexpr std::size_t kFlushBytes = 16;
  std::vector<std::byte> out(deflateBound(&stream, block.size()) + kFlushBytes);
  stream.next_in = bytesAt(block);
  stream.avail_in = static_cast<uInt>(block.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_SYNC_FLUSH);
  out.resize(out.size() - stream.avail_out);
  deflateEnd(&stream);
  return out;
}

std::uint32_t crcOf(std::span<const std::byte> data) {
  return static_cast<std::uint32_t>(
      crc32_z(crc32_z(0, nullptr, 0), reinterpret_cast<const Bytef*>(data.data()), data.size()));
}

}  // namespace

GzipOutput::GzipOutput(Sink sink) : sink_(std::move(sink)) {
  // Magic, deflate, no flags, no time, no hint, unknown system.
  constexpr std::uint8_t kHeader[] = {0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 255};
  sink_(std::as_bytes(std::span(kHeader)));
}

std::uint64_t GzipOutput::bytes(unsigned threads) {
  constexpr std::uint64_t kDeflateState = 272 << 10;
  return kWindow + threads * (2 * (kBlock + kBlock / 512) + kDeflateState);
}

// A block for each thread is held. Blocks begin at multiples of their length, so the bytes do not depend on threads.
void GzipOutput::write(std::span<const std::byte> data) {
  const std::size_t most = ThreadLimit::active() * kBlock;
  held_.reserve(kWindow + most);
  while (!data.empty()) {
    const std::size_t room = held_begin_ + most - held_.size(), taken = std::min(room, data.size());
    held_.insert(held_.end(), data.begin(), data.begin() + static_cast<std::ptrdiff_t>(taken));
    data = data.subspan(taken);
    if (taken == room) compressHeld();
  }
}

void GzipOutput::compressHeld() {
  const std::span<const std::byte> held = held_;
  const std::size_t bytes = held.size() - held_begin_, count = (bytes + kBlock - 1) / kBlock;
  std::vector<std::vector<std::byte>> packed(count);
  std::vector<std::uint32_t> checksums(count);
  const auto block = [&](std::size_t i) {
    return held.subspan(held_begin_ + i * kBlock, std::min(kBlock, bytes - i * kBlock));
  };
  parallelFor(count, [&](std::size_t i) {
    const std::size_t begin = held_begin_ + i * kBlock, window = std::min(begin, kWindow);
    packed[i] = deflatedBlock(held.subspan(begin - window, window), block(i));
    checksums[i] = crcOf(block(i));
  });
  for (std::size_t i = 0; i < count; ++i) {
    checksum_ =
        static_cast<std::uint32_t>(crc32_combine(checksum_, checksums[i], static_cast<z_off_t>(block(i).size())));
    sink_(packed[i]);
  }
  length_ += bytes;
  const std::size_t kept = std::min(held.size(), kWindow);
  held_.erase(held_.begin(), held_.end() - static_cast<std::ptrdiff_t>(kept));
  held_begin_ = kept;
}

void GzipOutput::finish() {
  compressHeld();
  constexpr std::uint8_t kEmptyLastBlock[] = {0x03, 0x00};
  sink_(std::as_bytes(std::span(kEmptyLastBlock)));
  std::vector<std::byte> trailer;
  appendValue(trailer, checksum_);
  appendValue(trailer, static_cast<std::uint32_t>(length_));
  sink_(trailer);
}

}  // namespace kiln
