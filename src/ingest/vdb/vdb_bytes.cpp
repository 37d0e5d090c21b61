#include "ingest/vdb/vdb_bytes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <string>

#include "base/error.h"
#include "ingest/codec/block_codecs.h"
#include "ingest/codec/blosc_frame.h"

namespace kiln {
namespace {

[[noreturn]] void failAt(const File& file, std::uint64_t at, const std::string& what) {
  throw Error(ErrorCode::kFormat, file.path(), fmt::format("byte {}", at), what);
}

/// A window of a file for reads that mostly go forward.
class FileWindow {
 public:
  explicit FileWindow(const File& file) : file_(file) {}
  void copy(std::uint64_t at, std::span<std::byte> out) {
    if (out.size() > kBytes) return file_.readAt(at, out);
    if (at < begin_ || at + out.size() > begin_ + window_.size()) {
      window_.resize(kBytes);
      window_.resize(file_.readSomeAt(at, window_));
      begin_ = at;
      if (window_.size() < out.size()) return file_.readAt(at, out);  // which throws
    }
    std::copy_n(window_.begin() + static_cast<std::ptrdiff_t>(at - begin_), out.size(), out.begin());
  }

 private:
  static constexpr std::size_t kBytes = 1 << 16;
  const File& file_;
  std::uint64_t begin_ = 0;
  std::vector<std::byte> window_;
};

}  // namespace

void VdbBytes::setPacked(std::span<const VdbPacked> parts) {
  dropWindow(position());
  parts_ = parts;
}

void VdbBytes::dropWindow(std::uint64_t at) {
  begin_ = end_ = at;
  is_unpacked_ = false;
  setg(nullptr, nullptr, nullptr);
}

std::uint64_t VdbBytes::position() const {
  if (is_unpacked_) return gptr() == egptr() ? end_ : begin_;
  return begin_ + static_cast<std::uint64_t>(gptr() - eback());
}

// Returns the first part at `at` or behind; null if there is none.
const VdbPacked* VdbBytes::partFrom(std::uint64_t at) const {
  const auto found = std::ranges::lower_bound(parts_, at, {}, &VdbPacked::at);
  return found == parts_.end() ? nullptr : &*found;
}

VdbBytes::int_type VdbBytes::underflow() {
  begin_ = end_;
  const VdbPacked* const part = partFrom(begin_);
  is_unpacked_ = part != nullptr && part->at == begin_;
  if (is_unpacked_) {
    unpack(*part);
  } else {
    const std::uint64_t most = part == nullptr ? raw_.size() : part->at - begin_;
    const std::span<char> to = std::span(raw_).first(std::min<std::uint64_t>(raw_.size(), most));
    const std::size_t got = file_.readSomeAt(begin_, std::as_writable_bytes(to));
    end_ = begin_ + got;
    show(raw_, got);
  }
  return gptr() == egptr() ? traits_type::eof() : traits_type::to_int_type(*gptr());
}

// The window becomes the part as OpenVDB stores it without compression: a negative length, then the values. A hint
// becomes an entry without value.
void VdbBytes::unpack(const VdbPacked& part) {
  if (part.kind == VdbPacked::Kind::kHint) {
    std::uint32_t length = 0;
    file_.readAt(part.at, std::as_writable_bytes(std::span(&length, 1)));
    end_ = part.at + sizeof length + length;
    unpacked_.assign(sizeof length, '\0');
    return show(unpacked_, unpacked_.size());
  }
  std::int64_t length = 0;
  file_.readAt(part.at, std::as_writable_bytes(std::span(&length, 1)));
  const std::uint64_t from = part.at + sizeof length;
  if (length <= 0 || static_cast<std::uint64_t>(length) > file_.size() - from)
    failAt(file_, part.at, "has changed while it was read");
  packed_.resize(static_cast<std::size_t>(length));
  file_.readAt(from, packed_);
  end_ = from + packed_.size();
  unpacked_.resize(std::max(unpacked_.size(), sizeof length + part.bytes));
  const std::int64_t kept = -std::int64_t{part.bytes};
  std::memcpy(unpacked_.data(), &kept, sizeof kept);
  unpackValues(part, packed_, std::as_writable_bytes(std::span(unpacked_)).subspan(sizeof length, part.bytes));
  show(unpacked_, sizeof length + part.bytes);
}

void VdbBytes::unpackValues(const VdbPacked& part, std::span<const std::byte> packed, std::span<std::byte> out) const {
  std::size_t written = 0;
  std::string fault;
  if (part.kind == VdbPacked::Kind::kBlosc) {
    fault = unpackBlosc(packed, out, written);
  } else {
    const std::optional<std::size_t> bytes = unpackDeflate(packed, DeflateWrapper::kZlib, out);
    if (!bytes) fault = "the zlib stream is damaged";
    written = bytes.value_or(0);
  }
  if (fault.empty() && written != out.size())
    fault = fmt::format("packed values have {} bytes (expected {})", written, out.size());
  if (!fault.empty()) failAt(file_, part.at, fault);
}

std::streamsize VdbBytes::xsgetn(char* to, std::streamsize count) {
  const std::uint64_t at = position();
  const std::streamsize got = count < 0 ? 0 : std::streambuf::xsgetn(to, count);
  if (got != count)
    failAt(file_, at, fmt::format("the file ends after {} bytes, but {} more are expected here", file_.size(), count));
  return got;
}

// The position itself is asked for before each leaf.
VdbBytes::pos_type VdbBytes::seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) {
  if (from == std::ios_base::cur && offset == 0) return static_cast<pos_type>(static_cast<off_type>(position()));
  const std::uint64_t base = from == std::ios_base::beg ? 0 : from == std::ios_base::cur ? position() : file_.size();
  const off_type to = static_cast<off_type>(base) + offset;
  if (to < 0 || static_cast<std::uint64_t>(to) > file_.size()) return pos_type(off_type(-1));
  dropWindow(static_cast<std::uint64_t>(to));
  return pos_type(to);
}

VdbBytes::pos_type VdbBytes::seekpos(pos_type to, std::ios_base::openmode mode) {
  return seekoff(static_cast<off_type>(to), std::ios_base::beg, mode);
}

VdbLengths vdbLengths(const File& file) {
  const auto window = std::make_shared<FileWindow>(file);
  return VdbLengths({file.path(), ErrorCode::kFormat, file.size(),
                     [window](std::uint64_t at, std::span<std::byte> out) { window->copy(at, out); }});
}

}  // namespace kiln
