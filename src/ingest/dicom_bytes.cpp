#include "ingest/dicom_bytes.h"

#include <fmt/format.h>

#include "base/error.h"

namespace kiln {

std::string nameOf(DicomTag tag) { return fmt::format("({:04x},{:04x})", tag >> 16, tag & 0xffff); }

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
    file_.readAt(at_, std::as_writable_bytes(std::span(out)));
  } else {
    if (at_ < buffered_at_ || at_ + bytes > buffered_at_ + buffered_) {
      buffered_at_ = at_;
      buffered_ = file_.readSomeAt(at_, std::as_writable_bytes(std::span(buffer_)));
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
  throw Error(ErrorCode::kFormat, file_.path(), fmt::format("byte {}", at_),
              what + "; the DICOM file is cut short or damaged");
}

}  // namespace kiln
