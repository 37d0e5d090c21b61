// A forward cursor over the bytes of a DICOM file: tags, integers and texts in either byte order.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>

#include "base/file/file.h"
#include "ingest/bytes/inflate_stream.h"

namespace kiln {

/// Group and element numbers: (0028,0010) is 0x00280010.
using DicomTag = std::uint32_t;

/// "(0028,0010)".
std::string nameOf(DicomTag tag);

/// Markers in front of an item of a sequence (or a fragment of the pixels), and behind the last item.
inline constexpr DicomTag kDicomItem = 0xfffee000, kDicomSequenceEnd = 0xfffee0dd;

/// True for the first bytes of a DICOM file: DICM at byte 128, or, in files from before 1996, two elements of the first
/// groups.
/// shape: 512 bytes are enough.
bool looksLikeDicom(std::string_view first_bytes);

/// The elements of a file that is deflated as a whole. Source: DICOM PS3.5, A.5.
class DicomInflated {
 public:
  /// The stream begins at `offset_bytes` of the file.
  DicomInflated(const std::filesystem::path& path, std::uint64_t offset_bytes)
      : path_(path), offset_bytes_(offset_bytes) {}
  /// Reads up to `out.size()` bytes from `at` of the inflated elements; returns the number of bytes read.
  /// cost: inflates the bytes between the last read and `at`, or from the start if `at` lies before the last read.
  /// throws: Error kFormat if the stream is cut or damaged; kIo.
  std::size_t readSomeAt(std::uint64_t at, std::span<std::byte> out);

 private:
  std::filesystem::path path_;
  std::uint64_t offset_bytes_;
  std::unique_ptr<InflateStream> stream_;
  std::uint64_t next_ = 0;  // position of the stream
};

/// A position in a file that moves forward only. Moving beyond the file's end throws Error kFormat with the byte.
class DicomBytes {
 public:
  /// requires: `file` outlives this, and `at` is not beyond its end.
  DicomBytes(const File& file, std::uint64_t at) : file_(file), at_(at) {}

  bool big_endian = false;
  /// Continues in the deflated stream that begins here; positions then count from 0.
  void inflate();
  /// unit: bytes of the file, or of the inflated stream.
  std::uint64_t at() const { return at_; }
  /// The number of bytes that follow. An inflated stream has an unknown length: the result is above every length field.
  std::uint64_t left() const { return inflated_ ? kUnknown : file_.size() - at_; }
  /// True if another byte follows.
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
