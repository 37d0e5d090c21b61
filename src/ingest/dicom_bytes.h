// The bytes of a DICOM file as its elements are made of them: tags and numbers in one of two orders, read forwards.
#pragma once

#include <array>
#include <string>

#include "base/file.h"

namespace kiln {

/// A group and an element: (0028,0010) is 0x00280010.
using DicomTag = std::uint32_t;

/// "(0028,0010)".
std::string nameOf(DicomTag tag);

/// What stands in front of an item of a sequence or a fragment of the pixels, and behind the last.
inline constexpr DicomTag kDicomItem = 0xfffee000, kDicomSequenceEnd = 0xfffee0dd;

/// A place in a file that goes forward only. Whatever goes beyond the file throws Error kFormat, with the byte.
class DicomBytes {
 public:
  /// requires: `file` outlives this, and `at` is not beyond its end.
  DicomBytes(const File& file, std::uint64_t at) : file_(file), at_(at) {}

  bool big_endian = false;
  /// unit: bytes of the file.
  std::uint64_t at() const { return at_; }
  std::uint64_t left() const { return file_.size() - at_; }

  std::uint32_t integer(int bytes);
  DicomTag tag();
  std::string text(std::size_t bytes);
  void skip(std::uint64_t bytes);
  [[noreturn]] void fail(const std::string& what) const;

 private:
  const File& file_;
  std::uint64_t at_;
  std::array<char, 4096> buffer_{};
  std::uint64_t buffered_at_ = 0;
  std::size_t buffered_ = 0;
};

}  // namespace kiln
