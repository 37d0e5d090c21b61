// An array without a compressor is its length, then its bytes, in one piece of base64. A compressed array is a table,
// then the packed blocks, in a second piece. The table has the number of blocks, the size of a block, the size of a
// shorter last block (else 0), and the packed size of each block.
// Invariant: the lengths are checked against the array's size before memory is taken for a table or a block.
#include "ingest/vtk/vti_bytes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "ingest/bytes/header_bytes.h"

namespace kiln {
namespace {

// Upper bound for the expansion by any codec: LZMA's runs.
constexpr std::uint64_t kMostExpansion = 10000;
constexpr std::size_t kGroupsAtOnce = 1 << 14;

int valueOfBase64(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

// Decodes a group of four characters. Returns the number of bytes, 0 if the group is no base64.
std::size_t decodeGroup(const char* group, std::byte* out) {
  const std::size_t padding = group[3] != '=' ? 0 : group[2] != '=' ? 1 : 2;
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const int value = i >= 4 - padding ? 0 : valueOfBase64(group[i]);
    if (value < 0) return 0;
    bits = bits << 6 | static_cast<std::uint32_t>(value);
  }
  for (int i = 0; i < 3; ++i) out[i] = static_cast<std::byte>(bits >> (16 - 8 * i));
  return 3 - padding;
}

}  // namespace

void VtiText::read(std::uint64_t offset, std::span<std::byte> out) const {
  if (!base64_) return file_.readAt(begin_ + offset, out);
  std::string text;
  std::uint64_t group = offset / 3;
  std::size_t skip = offset % 3;
  for (std::size_t done = 0; done < out.size();) {
    const std::uint64_t wanted = (out.size() - done + skip + 2) / 3;
    text.resize(4 * static_cast<std::size_t>(std::min<std::uint64_t>(wanted, kGroupsAtOnce)));
    file_.readAt(begin_ + 4 * group, std::as_writable_bytes(std::span(text)));
    for (std::size_t at = 0; at < text.size(); at += 4) {
      std::byte bytes[3];
      const std::size_t count = decodeGroup(text.data() + at, bytes), used = std::min(3 - skip, out.size() - done);
      if (count < skip + used)
        throw Error(ErrorCode::kFormat, file_.path(), fmt::format("byte {}", begin_ + 4 * group + at),
                    "the array's base64 ends here, or has other characters; the file is cut short or damaged");
      std::memcpy(out.data() + done, bytes + skip, used);
      done += used;
      skip = 0;
    }
    group += text.size() / 4;
  }
}

std::uint64_t VtiText::after(std::uint64_t bytes) const { return begin_ + (base64_ ? (bytes + 2) / 3 * 4 : bytes); }

VtiArrayBytes::VtiArrayBytes(VtiText text, VtiLengths lengths, BlockCodec codec, std::uint64_t bytes,
                             std::uint64_t memory_bytes)
    : text_(std::move(text)), codec_(codec), bytes_(bytes) {
  if (codec == BlockCodec::kNone)
    readLength(lengths);
  else
    readBlockTable(lengths, memory_bytes);
}

void VtiArrayBytes::fail(const std::string& what) const {
  throw Error(ErrorCode::kFormat, text_.file().path(), fmt::format("byte {}", text_.begin()), what);
}

std::vector<std::uint64_t> VtiArrayBytes::numbers(VtiLengths lengths, std::uint64_t offset, std::uint64_t count) const {
  std::vector<std::byte> raw(static_cast<std::size_t>(count) * lengths.size());
  text_.read(offset, raw);
  HeaderBytes bytes(text_.file().path(), std::move(raw));
  bytes.setBigEndian(lengths.big_endian);
  std::vector<std::uint64_t> out(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = lengths.wide ? bytes.get<std::uint64_t>(8 * i) : bytes.get<std::uint32_t>(4 * i);
  return out;
}

void VtiArrayBytes::readLength(VtiLengths lengths) {
  length_bytes_ = lengths.size();
  const std::uint64_t length = numbers(lengths, 0, 1)[0];
  // 32 bits count larger arrays modulo 4 GiB.
  const std::uint64_t expected = lengths.wide ? bytes_ : bytes_ & UINT32_MAX;
  if (length != expected)
    fail(fmt::format("the array has {} bytes, but the extent needs {}; the file is damaged", length, bytes_));
  const std::uint64_t end = text_.after(lengths.size() + bytes_), size = text_.file().size();
  if (end > size) fail(fmt::format("the array ends at byte {}, but the file has {}; it is cut short", end, size));
}

void VtiArrayBytes::readBlockTable(VtiLengths lengths, std::uint64_t memory_bytes) {
  const std::vector<std::uint64_t> head = numbers(lengths, 0, 3);
  const std::uint64_t count = head[0], last = head[2], size = text_.file().size();
  const std::uint64_t block = head[1], whole = count - (last > 0 ? 1 : 0);
  if (count == 0 || last >= block || whole > bytes_ / block || whole * block + last != bytes_)
    fail(fmt::format("the array has {} blocks of {} bytes and a last one of {}, but the extent needs {} bytes", count,
                     block, last, bytes_));
  // A single block may be shorter than the length of blocks, which is then any number.
  block_bytes_ = std::min(block, bytes_);
  if (count > size / lengths.size()) fail(fmt::format("a table of {} blocks is longer than the file", count));
  if (count > memory_bytes / (2 * sizeof(std::uint64_t)))
    throw Error(ErrorCode::kBudget, text_.file().path(), "",
                fmt::format("the table of {} compressed blocks does not fit into the memory allowed", count));
  ends_ = numbers(lengths, 3 * lengths.size(), count);
  std::uint64_t end = 0, left = bytes_;
  for (std::uint64_t& entry : ends_) {
    const std::uint64_t unpacked = std::min(block_bytes_, left);
    if (entry > size || unpacked / kMostExpansion > entry)
      fail(fmt::format("a block of {} bytes has {} packed bytes", unpacked, entry));
    left -= unpacked;
    packed_bytes_ = std::max(packed_bytes_, entry);
    entry = end += entry;
  }
  text_.moveTo(text_.after((3 + count) * lengths.size()));
  if (text_.after(end) > size)
    fail(fmt::format("the blocks end at byte {}, but the file has {}; it is cut short", text_.after(end), size));
}

BlockCache::Bytes VtiArrayBytes::decode(std::uint64_t block) const {
  const std::uint64_t begin = block == 0 ? 0 : ends_[block - 1];
  std::vector<std::byte> packed(static_cast<std::size_t>(ends_[block] - begin));
  text_.read(begin, packed);
  BlockCache::Bytes out(static_cast<std::size_t>(std::min(block_bytes_, bytes_ - block * block_bytes_)));
  if (!unpackBlock(codec_, packed, out))
    throw Error(ErrorCode::kFormat, text_.file().path(), fmt::format("block {}", block),
                "the compressed data are damaged; get the file again");
  return out;
}

std::uint64_t VtiArrayBytes::decodeBytes() const {
  return codec_ == BlockCodec::kNone ? kChunkBytes : block_bytes_ + packed_bytes_ + unpackMemory(codec_);
}

void VtiArrayBytes::read(std::uint64_t offset, std::span<std::byte> out) {
  if (codec_ == BlockCodec::kNone) return text_.read(length_bytes_ + offset, out);
  for (std::size_t done = 0; done < out.size();) {
    const std::uint64_t at = offset + done, block = at / block_bytes_;
    const auto bytes =
        cache_.get({0, static_cast<std::int64_t>(block)}, [&](BlockCache::Bytes) { return decode(block); });
    const auto from = static_cast<std::size_t>(at - block * block_bytes_);
    const std::size_t count = std::min(bytes->size() - from, out.size() - done);
    std::memcpy(out.data() + done, bytes->data() + from, count);
    done += count;
  }
}

}  // namespace kiln
