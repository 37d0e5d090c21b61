#include "ingest/dicom/dicom_bytes.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "base/error.h"

namespace kiln {

std::string nameOf(DicomTag tag) { return fmt::format("({:04x},{:04x})", tag >> 16, tag & 0xffff); }

namespace {

constexpr std::size_t kPreambleBytes = 128;

std::uint32_t littleEndian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint32_t out = 0;
  for (std::size_t i = count; i-- > 0;) out = out << 8 | static_cast<unsigned char>(bytes[at + i]);
  return out;
}

bool isRepresentation(std::string_view text) {
  constexpr std::string_view kAll =
      "AE AS AT CS DA DS DT FD FL IS LO LT OB OD OF OL OV OW PN SH SL SQ SS ST SV TM UC UI UL UN UR US UT UV";
  const std::size_t at = kAll.find(text);
  return text.size() == 2 && at != std::string_view::npos && at % 3 == 0;
}

// Returns the end of an element that may begin a file without preamble; 0 if there is no such element.
std::size_t endOfFirstElement(std::string_view bytes, std::size_t at) {
  constexpr std::uint32_t kMostBytes = 256;  // enough for identifiers and dates
  if (bytes.size() < at + 8) return 0;
  const bool big_endian = bytes[at] == 0;
  const std::uint32_t group = big_endian ? static_cast<unsigned char>(bytes[at + 1]) : littleEndian(bytes, at, 2);
  if (group != 2 && group != 8) return 0;
  const std::string_view representation = bytes.substr(at + 4, 2);
  if (isRepresentation(representation)) {
    if (representation == "OB" || representation == "UN")
      return bytes.size() < at + 12 ? 0 : at + 12 + littleEndian(bytes, at + 8, 4);
    return at + 8 + (big_endian ? static_cast<unsigned char>(bytes[at + 7]) : littleEndian(bytes, at + 6, 2));
  }
  const std::uint32_t length = littleEndian(bytes, at + 4, 4);
  return big_endian || length > kMostBytes || length % 2 == 1 ? 0 : at + 8 + length;
}

}  // namespace

bool looksLikeDicom(std::string_view bytes) {
  if (bytes.size() >= kPreambleBytes + 4 && bytes.substr(kPreambleBytes, 4) == "DICM") return true;
  const std::size_t second = endOfFirstElement(bytes, 0);
  return second > 0 && endOfFirstElement(bytes, second) > 0;
}

std::size_t DicomInflated::readSomeAt(std::uint64_t at, std::span<std::byte> out) {
  const std::string where = "the deflated elements";
  if (!stream_ || at < next_) {
    stream_ = std::make_unique<InflateStream>(File(path_), offset_bytes_, StreamWrapper::kNone);
    next_ = 0;
  }
  std::vector<std::byte> dropped(static_cast<std::size_t>(std::min<std::uint64_t>(at - next_, 1 << 16)));
  while (next_ < at) {
    const auto most = static_cast<std::size_t>(std::min<std::uint64_t>(at - next_, dropped.size()));
    const std::size_t got = stream_->readSome(std::span(dropped).first(most), where);
    if (got == 0) return 0;
    next_ += got;
  }
  const std::size_t got = stream_->readSome(out, where);
  next_ += got;
  return got;
}

void DicomBytes::inflate() {
  inflated_ = std::make_shared<DicomInflated>(file_.path(), at_);
  at_ = buffered_at_ = buffered_ = 0;
}

std::size_t DicomBytes::readSomeAt(std::uint64_t at, std::span<std::byte> out) {
  return inflated_ ? inflated_->readSomeAt(at, out) : file_.readSomeAt(at, out);
}

bool DicomBytes::more() {
  if (!inflated_) return left() > 0;
  if (at_ >= buffered_at_ && at_ < buffered_at_ + buffered_) return true;
  buffered_at_ = at_;
  buffered_ = readSomeAt(at_, std::as_writable_bytes(std::span(buffer_)));
  return buffered_ > 0;
}

std::uint32_t DicomBytes::integer(int bytes) {
  const std::string raw = text(static_cast<std::size_t>(bytes));
  std::uint32_t out = 0;
  for (int i = 0; i < bytes; ++i) {
    const auto byte = static_cast<unsigned char>(raw[static_cast<std::size_t>(big_endian ? bytes - 1 - i : i)]);
    out |= static_cast<std::uint32_t>(byte) << (8 * i);
  }
  return out;
}

DicomTag DicomBytes::tag() {
  const std::uint32_t group = integer(2);
  return group << 16 | integer(2);
}

std::string DicomBytes::text(std::size_t bytes) {
  if (bytes > left()) fail("the file ends here");
  std::string out(bytes, '\0');
  if (bytes > buffer_.size()) {
    if (readSomeAt(at_, std::as_writable_bytes(std::span(out))) < bytes) fail("the file ends here");
  } else {
    if (at_ < buffered_at_ || at_ + bytes > buffered_at_ + buffered_) {
      buffered_at_ = at_;
      buffered_ = readSomeAt(at_, std::as_writable_bytes(std::span(buffer_)));
      if (buffered_ < bytes) fail("the file ends here");
    }
    out.assign(buffer_.data() + (at_ - buffered_at_), bytes);
  }
  at_ += bytes;
  return out;
}

void DicomBytes::skip(std::uint64_t bytes) {
  if (bytes > left()) fail(fmt::format("{} bytes should follow, but the file ends after {}", bytes, left()));
  at_ += bytes;
}

void DicomBytes::fail(const std::string& what) const {
  throw Error(ErrorCode::kFormat, file_.path(),
              fmt::format("byte {}{}", at_, inflated_ ? " of the inflated elements" : ""),
              what + "; the DICOM file is cut short or damaged");
}

}  // namespace kiln
