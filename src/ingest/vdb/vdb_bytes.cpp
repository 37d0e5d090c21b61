#include "ingest/vdb/vdb_bytes.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>

#include "base/error.h"

namespace kiln {

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

VdbLengths vdbLengths(const File& file) {
  return VdbLengths({file.path(), ErrorCode::kFormat, file.size(),
                     [&file](std::uint64_t at, std::span<std::byte> out) { file.readAt(at, out); }});
}

}  // namespace kiln
