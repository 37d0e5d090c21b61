#include "ingest/dicom/dicom_codestream.h"

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>

#include "ingest/bytes/jpeg2000_size.h"

namespace kiln {
namespace {

constexpr const char* kRunLengths = "1.2.840.10008.1.2.5";

struct FrameSize {
  std::uint64_t columns = 0, rows = 0;
  int bits = 0, components = 0;
};

// The bytes of a frame. Reads beyond the end are tested by `has`.
class Codestream {
 public:
  explicit Codestream(std::span<const std::byte> bytes) : bytes_(bytes) {}
  std::size_t size() const { return bytes_.size(); }
  std::span<const std::byte> from(std::size_t at) const { return bytes_.subspan(at); }
  bool has(std::size_t at, std::size_t count) const { return at <= size() && count <= size() - at; }
  int byte(std::size_t at) const { return std::to_integer<int>(bytes_[at]); }
  std::uint64_t big(std::size_t at, int count) const {
    std::uint64_t out = 0;
    for (int i = 0; i < count; ++i) out = out << 8 | static_cast<std::uint64_t>(byte(at + static_cast<std::size_t>(i)));
    return out;
  }
  std::uint64_t little4(std::size_t at) const {
    std::uint64_t out = 0;
    for (std::size_t i = 4; i-- > 0;) out = out << 8 | static_cast<std::uint64_t>(byte(at + i));
    return out;
  }

 private:
  std::span<const std::byte> bytes_;
};

// Walks a JPEG or JPEG-LS stream from its first marker to its first scan, because GDCM crashes on some streams with
// damaged segments. Source: ITU-T T.81, B.2; T.87, C.1.
class JpegWalk {
 public:
  JpegWalk(const Codestream& stream, const std::string& syntax) : s_(stream), syntax_(syntax) {}

  /// Returns the fault found; empty if the segments are sound. `size` is then the frame's size.
  std::string fault() {
    std::size_t at = 2;
    while (true) {
      while (s_.has(at, 2) && s_.byte(at) == 0xff && s_.byte(at + 1) == 0xff) ++at;  // fill bytes
      if (!s_.has(at, 4)) return "ends in front of its pixels";
      const int marker = s_.byte(at + 1);
      if (s_.byte(at) != 0xff || marker < 0xc0 || isBare(marker))
        return fmt::format("has bytes at {} that are no segment of JPEG", at);
      const std::uint64_t length = s_.big(at + 2, 2);
      if (length < 2 || !s_.has(at + 2, length)) return fmt::format("ends within its segment at byte {}", at);
      const std::size_t body = at + 4, bytes = static_cast<std::size_t>(length) - 2;
      if (std::string wrong = segmentFault(marker, body, bytes); !wrong.empty()) return wrong;
      if (marker == kScan) return size ? "" : "has no frame in front of its pixels";
      at += 2 + static_cast<std::size_t>(length);
    }
  }
  std::optional<FrameSize> size;

 private:
  static constexpr int kTables = 0xc4, kScan = 0xda, kLosslessFrame = 0xc3, kLsFrame = 0xf7;

  // True for markers without a segment: restarts, begin and end of an image.
  static bool isBare(int marker) { return marker >= 0xd0 && marker <= 0xd9; }
  static bool isFrame(int marker) {
    const bool tables = marker == kTables || marker == 0xc8 || marker == 0xcc;
    return (marker >= 0xc0 && marker <= 0xcf && !tables) || marker == kLsFrame;
  }

  // True if the frame belongs to the family of the file's transfer syntax: JPEG-LS, or JPEG in one scan, lossy or
  // lossless.
  bool isOfSyntax(int marker) const {
    const bool ls = syntax_.ends_with(".80") || syntax_.ends_with(".81");
    return ls ? marker == kLsFrame : marker == 0xc0 || marker == 0xc1 || marker == kLosslessFrame;
  }

  std::string segmentFault(int marker, std::size_t body, std::size_t bytes) {
    if (isFrame(marker)) return frameFault(marker, body, bytes);
    if (marker == kTables) return tableFault(body, bytes);
    if (marker == kScan) return scanFault(body, bytes);
    return "";
  }

  std::string frameFault(int marker, std::size_t body, std::size_t bytes) {
    constexpr std::size_t kHead = 6, kComponent = 3;
    if (size) return "has two frames";
    if (bytes < kHead || bytes != kHead + kComponent * static_cast<std::size_t>(s_.byte(body + 5)))
      return "has a frame header of the wrong length";
    if (!isOfSyntax(marker))
      return fmt::format("has a frame of kind {:x}, which is not that of its transfer syntax", marker);
    size = FrameSize{s_.big(body + 3, 2), s_.big(body + 1, 2), s_.byte(body), s_.byte(body + 5)};
    lossless_ = marker == kLosslessFrame;
    return "";
  }

  // Huffman tables: class and number, the number of codes of each length, and their values.
  std::string tableFault(std::size_t at, std::size_t bytes) const {
    constexpr std::size_t kHead = 17;
    const std::size_t end = at + bytes;
    while (at < end) {
      if (end - at < kHead) return "has a Huffman table that is cut short";
      std::size_t codes = 0, room = 1;  // codes still unused at this length
      for (std::size_t i = 1; i < kHead; ++i) {
        const auto of_length = static_cast<std::size_t>(s_.byte(at + i));
        room = 2 * room;
        if (of_length > room) return "has a Huffman table with more codes than there can be";
        room -= of_length;
        codes += of_length;
      }
      const int which = s_.byte(at);
      if ((which >> 4) > 1 || (which & 15) > 3 || codes > 256 || codes > end - at - kHead)
        return "has an invalid Huffman table";
      at += kHead + codes;
    }
    return "";
  }

  std::string scanFault(std::size_t body, std::size_t bytes) const {
    constexpr std::size_t kOfOneComponent = 6;
    if (bytes != kOfOneComponent || s_.byte(body) != 1) return "has a scan of more than one component";
    const int first = s_.byte(body + 3), shift = s_.byte(body + 5) & 15;
    if (lossless_ && size && (first < 1 || first > 7 || shift >= size->bits))
      return fmt::format("has predictor {} and a shift of {} bits, which lossless JPEG does not have", first, shift);
    return "";
  }

  const Codestream& s_;
  const std::string& syntax_;
  bool lossless_ = false;
};

std::optional<FrameSize> jpeg2000Size(const Codestream& s) {
  // "jP  ": a JP2 file around the codestream; DICOM needs the codestream alone
  constexpr std::uint64_t kBoxes = 0x6a502020;
  std::size_t at = 0;
  if (s.has(0, 8) && s.big(4, 4) == kBoxes)
    while (s.has(at, 4) && s.big(at, 4) != 0xff4fff51) ++at;
  const std::optional<Jpeg2000Size> size = jpeg2000SizeAt(s.from(at));
  if (!size) return std::nullopt;
  return FrameSize{size->columns, size->rows, size->bits, size->components};
}

// Returns the unpacked size of a run-length segment. Zeros may pad the segment behind `enough` bytes. unit: bytes.
std::uint64_t unpackedBytes(const Codestream& s, std::size_t at, std::size_t end, std::uint64_t enough) {
  std::uint64_t out = 0;
  const auto is_filling = [&] {
    for (std::size_t i = at; i < end; ++i)
      if (s.byte(i) != 0) return false;
    return true;
  };
  while (at < end) {
    if (out == enough && is_filling()) break;
    const int n = s.byte(at++);
    if (n == 128) continue;
    const std::size_t takes = n < 128 ? static_cast<std::size_t>(n) + 1 : 1;
    if (takes > end - at) break;
    at += takes;
    out += n < 128 ? takes : 257 - static_cast<std::uint64_t>(n);
  }
  return out;
}

std::string runLengthFault(const DicomPixels& pixels, const Codestream& s) {
  constexpr std::size_t kHeader = 64;
  const auto expected = static_cast<std::size_t>(pixels.bits_allocated / 8);
  if (!s.has(0, kHeader)) return fmt::format("has {} bytes, less than its own header", s.size());
  if (s.little4(0) != expected)
    return fmt::format("has {} run-length segments, but {} bits a pixel take {}", s.little4(0), pixels.bits_allocated,
                       expected);
  const auto count = static_cast<std::uint64_t>(pixels.columns * pixels.rows);
  for (std::size_t i = 0; i < expected; ++i) {
    const std::uint64_t begin = s.little4(4 + 4 * i), end = i + 1 < expected ? s.little4(8 + 4 * i) : s.size();
    if (begin < kHeader || begin > end || end > s.size())
      return fmt::format("places its run-length segment {} at bytes {} to {} of {}", i + 1, begin, end, s.size());
    if (const std::uint64_t bytes = unpackedBytes(s, begin, end, count); bytes != count)
      return fmt::format("unpacks to {} pixels, but the header says {} x {}", bytes, pixels.columns, pixels.rows);
  }
  return "";
}

// Size of a value that GDCM decodes from `bits` bits. unit: bytes.
int bytesFor(int bits) { return bits <= 8 ? 1 : bits <= 16 ? 2 : 4; }

}  // namespace

std::string codestreamFault(const DicomPixels& pixels, std::span<const std::byte> frame) {
  const Codestream s(frame);
  if (pixels.transfer_syntax == kRunLengths) return runLengthFault(pixels, s);
  if (!s.has(0, 4)) return fmt::format("has {} bytes", s.size());
  std::optional<FrameSize> found;
  const bool jpeg2000 = pixels.transfer_syntax.ends_with(".90") || pixels.transfer_syntax.ends_with(".91");
  if (jpeg2000) {
    found = jpeg2000Size(s);
  } else {
    if (s.big(0, 2) != 0xffd8) return "does not begin as JPEG does";
    JpegWalk walk(s, pixels.transfer_syntax);
    if (std::string fault = walk.fault(); !fault.empty()) return fault;
    found = walk.size;
  }
  if (!found) return "has no image size";
  const bool same = found->columns == static_cast<std::uint64_t>(pixels.columns) &&
                    found->rows == static_cast<std::uint64_t>(pixels.rows) && found->components == 1 &&
                    bytesFor(found->bits) == pixels.bits_allocated / 8;
  if (same) return "";
  return fmt::format("is {} x {} of {} bits and {} component{}, but the header says {} x {} of {} bits and 1",
                     found->columns, found->rows, found->bits, found->components, found->components == 1 ? "" : "s",
                     pixels.columns, pixels.rows, pixels.bits_allocated);
}

}  // namespace kiln
