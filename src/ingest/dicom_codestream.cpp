#include "ingest/dicom_codestream.h"

#include <fmt/format.h>

#include <cstdint>
#include <optional>

namespace kiln {
namespace {

constexpr const char* kRunLengths = "1.2.840.10008.1.2.5";

struct FrameSize {
  std::uint64_t columns = 0, rows = 0;
  int bits = 0, components = 0;
};

// The bytes of all fragments, one after the other; what is beyond the last is not there.
class Codestream {
 public:
  explicit Codestream(const std::vector<std::vector<char>>& fragments) {
    for (const std::vector<char>& fragment : fragments) bytes_.insert(bytes_.end(), fragment.begin(), fragment.end());
  }
  std::size_t size() const { return bytes_.size(); }
  bool has(std::size_t at, std::size_t count) const { return at <= size() && count <= size() - at; }
  int byte(std::size_t at) const { return static_cast<unsigned char>(bytes_[at]); }
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
  std::vector<char> bytes_;
};

// Of JPEG and JPEG-LS: the frame header is behind others, each with its length.
std::optional<FrameSize> jpegSize(const Codestream& s) {
  for (std::size_t at = 2; s.has(at, 4) && s.byte(at) == 0xff;) {
    const int marker = s.byte(at + 1);
    if (marker == 0xff) {  // filled up
      ++at;
      continue;
    }
    const bool tables = marker == 0xc4 || marker == 0xc8 || marker == 0xcc;
    if ((marker >= 0xc0 && marker <= 0xcf && !tables) || marker == 0xf7) {
      if (!s.has(at, 10)) return std::nullopt;
      return FrameSize{s.big(at + 7, 2), s.big(at + 5, 2), s.byte(at + 4), s.byte(at + 9)};
    }
    if (marker == 0xda || marker == 0xd9) return std::nullopt;  // pixels, or the end
    at += 2 + s.big(at + 2, 2);
  }
  return std::nullopt;
}

std::optional<FrameSize> jpeg2000Size(const Codestream& s) {
  constexpr std::uint64_t kBoxes = 0x6a502020;  // "jP  ", of files that are more than DICOM asks for
  std::size_t at = 0;
  if (s.has(0, 8) && s.big(4, 4) == kBoxes)
    while (s.has(at, 4) && s.big(at, 4) != 0xff4fff51) ++at;
  if (!s.has(at, 43) || s.big(at, 4) != 0xff4fff51) return std::nullopt;
  const std::uint64_t right = s.big(at + 8, 4), lower = s.big(at + 12, 4), left = s.big(at + 16, 4),
                      upper = s.big(at + 20, 4);
  if (right < left || lower < upper) return std::nullopt;
  return FrameSize{right - left, lower - upper, (s.byte(at + 42) & 0x7f) + 1, static_cast<int>(s.big(at + 40, 2))};
}

// How many bytes a run-length segment becomes. Behind `enough` of them zeros may fill it up.
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

// Of the values that GDCM makes of so many bits.
int bytesFor(int bits) { return bits <= 8 ? 1 : bits <= 16 ? 2 : 4; }

}  // namespace

std::string codestreamFault(const DicomPixels& pixels, const std::vector<std::vector<char>>& fragments) {
  const Codestream s(fragments);
  if (pixels.transfer_syntax == kRunLengths) return runLengthFault(pixels, s);
  if (!s.has(0, 4)) return fmt::format("has {} bytes", s.size());
  const std::optional<FrameSize> found = s.big(0, 2) == 0xffd8 ? jpegSize(s) : jpeg2000Size(s);
  if (!found) return "does not say how large it is";
  const bool same = found->columns == static_cast<std::uint64_t>(pixels.columns) &&
                    found->rows == static_cast<std::uint64_t>(pixels.rows) && found->components == 1 &&
                    bytesFor(found->bits) == pixels.bits_allocated / 8;
  if (same) return "";
  return fmt::format("is {} x {} of {} bits and {} component{}, but the header says {} x {} of {} bits and 1",
                     found->columns, found->rows, found->bits, found->components, found->components == 1 ? "" : "s",
                     pixels.columns, pixels.rows, pixels.bits_allocated);
}

}  // namespace kiln
