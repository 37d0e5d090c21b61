#include "ingest/vdb_bytes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <string>
#include <utility>

#include "base/error.h"

namespace kiln {
namespace {

// Walks what OpenVDB allocates by length: the file's metadata, the grids' names, the grids' metadata. Source: OpenVDB
// 10, MetaMap::readMeta, GridDescriptor::read, Archive::readGrid; file versions from 222 on (OpenVDB 3) have this form.
class LengthWalk {
 public:
  explicit LengthWalk(const File& file) : file_(file) {}

  void check() {
    constexpr std::uint64_t kHeaderBytes = 57;
    if (number<std::uint32_t>(8) < 222) return;
    const bool seekable = number<std::uint8_t>(20) != 0;
    at_ = kHeaderBytes;
    metadata();
    const std::int32_t grids = take<std::int32_t>();
    for (std::int32_t i = 0; seekable && i < grids; ++i) grid();
  }

 private:
  template <class T>
  T number(std::uint64_t at) const {
    std::array<std::byte, sizeof(T)> raw;
    file_.readAt(at, raw);
    return std::bit_cast<T>(raw);
  }
  template <class T>
  T take() {
    const T value = number<T>(at_);
    at_ += sizeof(T);
    return value;
  }
  void string() {
    const std::uint32_t length = take<std::uint32_t>();
    if (length > file_.size() - at_) fail(at_ - 4, fmt::format("a length of {} is more than the file holds", length));
    at_ += length;
  }
  // Entries of name, type and value, each with its length before it.
  void metadata() {
    const std::uint32_t count = take<std::uint32_t>();
    for (std::uint32_t i = 0; i < count; ++i) {
      string();
      const std::uint64_t type_at = at_ + 4;
      string();
      std::string type(at_ - type_at, '\0');
      file_.readAt(type_at, std::as_writable_bytes(std::span(type)));
      string();
      if (type == "__delayedload") delayedLoad(type_at + type.size() + 4);
    }
  }
  // A hint for loading later, with lengths of its own inside (DelayedLoadMetadata::readValue).
  void delayedLoad(std::uint64_t begin) {
    constexpr std::uint64_t kLeafBytes = 64;  // the least a leaf takes: its mask
    const std::uint64_t end = std::exchange(at_, begin);
    if (begin + 4 > end) return;
    const std::uint32_t leaves = take<std::uint32_t>();
    if (leaves > file_.size() / kLeafBytes) fail(begin, fmt::format("{} leaves are more than the file holds", leaves));
    for (const std::uint64_t raw_bytes : {1ull, 8ull}) {
      if (at_ + 4 > end) break;  // the second part is optional
      const std::uint32_t packed_bytes = take<std::uint32_t>();
      const std::uint64_t bytes = packed_bytes > 0 ? packed_bytes : raw_bytes * leaves;
      if (bytes > end - at_) fail(at_ - 4, fmt::format("a length of {} is more than the file holds", bytes));
      at_ += bytes;
    }
    at_ = end;
  }
  void grid() {
    for (int i = 0; i < 3; ++i) string();  // name, type, instance parent
    const std::int64_t data = take<std::int64_t>();
    const std::int64_t blocks = take<std::int64_t>();
    const std::int64_t end = take<std::int64_t>();
    const std::uint64_t next = at_;
    const bool instance = blocks == 0;
    if (data < static_cast<std::int64_t>(next) || end < data || (!instance && (blocks < data || blocks > end)) ||
        static_cast<std::uint64_t>(end) > file_.size()) {
      fail(next - 24, "a grid's place is not in the file; it is cut short or damaged");
    }
    at_ = static_cast<std::uint64_t>(data) + 4;  // the compression flags
    metadata();
    string();  // the name of the transform's map
    at_ = static_cast<std::uint64_t>(end);
  }
  [[noreturn]] void fail(std::uint64_t at, const std::string& what) const {
    throw Error(ErrorCode::kFormat, file_.path(), fmt::format("byte {}", at), what);
  }

  const File& file_;
  std::uint64_t at_ = 0;
};

}  // namespace

VdbBytes::int_type VdbBytes::underflow() {
  next_ += static_cast<std::uint64_t>(egptr() - eback());
  const std::size_t got = file_.readSomeAt(next_, std::as_writable_bytes(std::span(buffer_)));
  setg(buffer_.data(), buffer_.data(), buffer_.data() + got);
  return got == 0 ? traits_type::eof() : traits_type::to_int_type(buffer_[0]);
}

std::streamsize VdbBytes::xsgetn(char* to, std::streamsize count) {
  const std::uint64_t at = position();
  if (count < 0 || static_cast<std::uint64_t>(count) > file_.size() - std::min(at, file_.size())) {
    throw Error(ErrorCode::kFormat, file_.path(), fmt::format("byte {}", at),
                fmt::format("the file ends after {} bytes, but {} more are expected here", file_.size(), count));
  }
  return std::streambuf::xsgetn(to, count);
}

VdbBytes::pos_type VdbBytes::seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) {
  const std::uint64_t base = from == std::ios_base::beg ? 0 : from == std::ios_base::cur ? position() : file_.size();
  const off_type to = static_cast<off_type>(base) + offset;
  if (to < 0 || static_cast<std::uint64_t>(to) > file_.size()) return pos_type(off_type(-1));
  next_ = static_cast<std::uint64_t>(to);
  setg(nullptr, nullptr, nullptr);
  return pos_type(to);
}

VdbBytes::pos_type VdbBytes::seekpos(pos_type to, std::ios_base::openmode mode) {
  return seekoff(static_cast<off_type>(to), std::ios_base::beg, mode);
}

void requireVdbLengths(const File& file) { LengthWalk(file).check(); }

}  // namespace kiln
