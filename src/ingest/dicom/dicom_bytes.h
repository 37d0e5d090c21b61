// The bytes of a DICOM file as its elements are made of them: tags and numbers in one of two orders, read forwards.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>

#include "base/file.h"
#include "ingest/bytes/inflate_stream.h"

namespace kiln {

/// A group and an element: (0028,0010) is 0x00280010.
using DicomTag = std::uint32_t;

/// "(0028,0010)".
std::string nameOf(DicomTag tag);

/// What stands in front of an item of a sequence or a fragment of the pixels, and behind the last.
inline constexpr DicomTag kDicomItem = 0xfffee000, kDicomSequenceEnd = 0xfffee0dd;

/// True for the first bytes of a DICOM file: DICM at byte 128, whatever the bytes before are, or, in files of before
/// 1996, two elements of the first groups. shape: 512 bytes are enough.
bool looksLikeDicom(std::string_view first_bytes);

/// The elements of a file that is deflated as a whole. Source: DICOM PS3.5, A.5.
class DicomInflated {
 public:
  /// The stream begins at `offset_bytes` of the file.
  DicomInflated(const std::filesystem::path& path, std::uint64_t offset_bytes)
      : path_(path), offset_bytes_(offset_bytes) {}
  /// Up to `out.size()` bytes from `at` of the inflated elements; returns how many there were. cost: unpacks what lies
  /// between the last read and `at`; from the start where `at` lies before. throws: Error kFormat where the stream is
  /// cut or damaged; kIo.
  std::size_t readSomeAt(std::uint64_t at, std::span<std::byte> out);

 private:
  std::filesystem::path path_;
  std::uint64_t offset_bytes_;
  std::unique_ptr<InflateStream> stream_;
  std::uint64_t next_ = 0;  // the byte that the stream gives next
};

/// A place in a file that goes forward only. Whatever goes beyond the file throws Error kFormat, with the byte.
class DicomBytes {
 public:
  /// requires: `file` outlives this, and `at` is not beyond its end.
  DicomBytes(const File& file, std::uint64_t at) : file_(file), at_(at) {}

  bool big_endian = false;
  /// From here on the bytes are those of the deflated stream that begins here, counted from 0.
  void inflate();
  /// unit: bytes of the file, or of the inflated stream.
  std::uint64_t at() const { return at_; }
  /// The bytes that follow; for an inflated stream, whose length is not known, more than any length can say.
  std::uint64_t left() const { return inflated_ ? kUnknown : file_.size() - at_; }
  /// True where another byte follows.
  bool more();

  std::uint32_t integer(int bytes);
  DicomTag tag();
  std::string text(std::size_t bytes);
  void skip(std::uint64_t bytes);
  [[noreturn]] void fail(const std::string& what) const;

 private:
  static constexpr std::uint64_t kUnknown = std::uint64_t{1} << 62;
  std::size_t readSomeAt(std::uint64_t at, std::span<std::byte> out);

  const File& file_;
  std::shared_ptr<DicomInflated> inflated_;
  std::uint64_t at_;
  std::array<char, 4096> buffer_{};
  std::uint64_t buffered_at_ = 0;
  std::size_t buffered_ = 0;
};

}  // namespace kiln
