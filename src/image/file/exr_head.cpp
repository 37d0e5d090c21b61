#include "image/file/exr_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <string_view>

#include "base/error.h"
#include "image/pixel_rect.h"

namespace kiln {
namespace {

constexpr std::uint32_t kMagic = 0x01312f76;
// Flags in the version field.
constexpr std::uint32_t kTiled = 0x200, kSeveralParts = 0x1000;

// Size of a value of a fixed-size type. OpenEXR reads this many bytes, whatever length the file claims.
std::uint32_t bytesOfPixelType(const std::string& type) {
  static const std::map<std::string, std::uint32_t> kBytes = {{"box2i", 16},
                                                              {"box2f", 16},
                                                              {"chromaticities", 32},
                                                              {"compression", 1},
                                                              {"deepImageState", 1},
                                                              {"double", 8},
                                                              {"envmap", 1},
                                                              {"float", 4},
                                                              {"int", 4},
                                                              {"keycode", 28},
                                                              {"m33d", 72},
                                                              {"lineOrder", 1},
                                                              {"m33f", 36},
                                                              {"m44d", 128},
                                                              {"m44f", 64},
                                                              {"rational", 8},
                                                              {"tiledesc", 9},
                                                              {"timecode", 8},
                                                              {"v2d", 16},
                                                              {"v2f", 8},
                                                              {"v2i", 8},
                                                              {"v3d", 24},
                                                              {"v3f", 12},
                                                              {"v3i", 12}};
  const auto found = kBytes.find(type);
  return found == kBytes.end() ? 0 : found->second;
}

// Number of rows compressed together, by compression number; 0 if unknown.
std::uint64_t rowsOfChunk(int compression) {
  constexpr std::array<std::uint64_t, 10> kRows = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
  return compression >= 0 && static_cast<std::size_t>(compression) < kRows.size()
             ? kRows[static_cast<std::size_t>(compression)]
             : 0;
}

std::string nameOfCompression(int compression) {
  constexpr std::array kNames = {"none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"};
  return compression >= 0 && static_cast<std::size_t>(compression) < kNames.size()
             ? kNames[static_cast<std::size_t>(compression)]
             : fmt::format("{}", compression);
}

class HeadWalk {
 public:
  HeadWalk(const ExrBytes& bytes, const std::filesystem::path& path) : bytes_(bytes), path_(path) {}

  std::vector<ExrPart> run() {
    if (take<std::uint32_t>() != kMagic) fail(0, "the file is not OpenEXR");
    const auto version = take<std::uint32_t>();
    const bool several = (version & kSeveralParts) != 0;
    std::vector<ExrPart> parts;
    do {
      parts.push_back(part((version & kTiled) != 0));
    } while (several && number<std::uint8_t>(at_) != 0);
    if (several) skip(1);
    if (chunks_ > (bytes_.size - at_) / sizeof(std::uint64_t))
      fail(at_, fmt::format("the tables of its {} chunks are more than the file holds", chunks_));
    return parts;
  }

 private:
  // Attributes that decide the memory of a part.
  struct Layout {
    std::optional<std::array<std::int32_t, 4>> window;  // x and y of the first pixel, then of the last
    std::optional<int> compression;
    std::uint64_t pixel_bytes = 0;  // all channels together
    bool has_channels = false;
    std::optional<std::array<std::uint32_t, 2>> tile;
    std::uint64_t claimed_chunks = 0;
    std::string type;
  };

  ExrPart part(bool tiled) {
    const std::uint64_t begin = at_;
    ExrPart out;
    Layout layout;
    while (true) {
      const std::string name = text();
      if (name.empty()) break;
      attribute(name, out, layout);
    }
    if (!layout.window || !layout.has_channels || !layout.compression)
      fail(begin, "a part has no data window, channels or compression");
    const auto& w = *layout.window;
    out.x = w[0];
    out.y = w[1];
    out.width = std::int64_t{w[2]} - w[0] + 1;
    out.height = std::int64_t{w[3]} - w[1] + 1;
    if (std::min(out.width, out.height) < 1 || std::max(out.width, out.height) > kLargestSide_px)
      throw Error(ErrorCode::kUnsupported, path_, "dataWindow",
                  fmt::format("{}x{} pixels; each side must be from 1 to {}", out.width, out.height, kLargestSide_px));
    out.deep = layout.type.starts_with("deep");
    out.compression = nameOfCompression(*layout.compression);
    count(tiled || layout.type == "tiledimage" || layout.type == "deeptile", layout, out);
    return out;
  }

  void attribute(const std::string& name, ExrPart& part, Layout& layout) {
    const std::string type = text();
    const std::uint64_t length_at = at_;
    const auto claimed_length = take<std::int32_t>();
    const auto length = static_cast<std::uint64_t>(claimed_length);
    if (claimed_length < 0 || length > bytes_.size - at_)
      fail(length_at, fmt::format("{}: a length of {} is more than the file holds", name, claimed_length));
    if (const std::uint32_t bytes = bytesOfPixelType(type); bytes != 0 && bytes != length)
      fail(length_at,
           fmt::format("{}: a value of type {} has a length of {}; {} is legal", name, type, claimed_length, bytes));
    const std::uint64_t begin = at_, end = at_ + length;
    if (type == "string") part.text[name] = layoutText(name, length, layout);
    if (type == "stringvector") {
      while (at_ < end) skip(takeLength(end));
    }
    if (type == "chlist") channels(end, part, layout);
    if (type == "preview" && (length < 8 || length - 8 != previewBytes(begin)))
      fail(begin, fmt::format("{}: the size of the preview differs from the length of its value", name));
    if (name == "dataWindow" && type == "box2i") layout.window = number<std::array<std::int32_t, 4>>(begin);
    if (name == "compression" && type == "compression") layout.compression = number<std::uint8_t>(begin);
    if (name == "tiles" && type == "tiledesc") layout.tile = number<std::array<std::uint32_t, 2>>(begin);
    if (name == "chunkCount" && type == "int")
      layout.claimed_chunks = static_cast<std::uint64_t>(std::max(number<std::int32_t>(begin), 0));
    if (at_ > end) fail(begin, fmt::format("{}: the contents exceed the length of the value", name));
    at_ = end;
  }

  std::string layoutText(const std::string& name, std::uint64_t length, Layout& layout) {
    std::string out(static_cast<std::size_t>(length), '\0');
    bytes_.copy(at_, std::as_writable_bytes(std::span(out)));
    if (name == "type") layout.type = out;
    return out;
  }

  // Reads entries of name, type (0 uint, 1 half, 2 float), four bytes, and sampling distances in x and y.
  void channels(std::uint64_t end, ExrPart& part, Layout& layout) {
    constexpr std::array kTypes = {"uint", "half", "float"};
    layout.has_channels = true;
    part.channels.clear();
    while (true) {
      const std::string name = text();
      if (name.empty()) break;
      const auto type = take<std::int32_t>();
      skip(12);
      layout.pixel_bytes += type == 1 ? 2 : 4;
      part.channels.emplace_back(name, type >= 0 && type < 3 ? kTypes[static_cast<std::size_t>(type)] : "unknown");
    }
    if (at_ != end) fail(at_, "the list of channels does not match its length");
  }

  std::uint64_t previewBytes(std::uint64_t at) const {
    return 4 * (std::uint64_t{number<std::uint32_t>(at)} * number<std::uint32_t>(at + 4) & 0xffffffffffff);
  }

  // Checks the number of chunks and computes the buffers of a part. OpenEXR holds a chunk stored, unpacked, and in the
  // codec's working copy; for a tiled file that is read by rows, a row of tiles.
  void count(bool tiled, const Layout& layout, ExrPart& part) {
    constexpr std::uint64_t kCopies = 3;
    const auto width = static_cast<std::uint64_t>(part.width), height = static_cast<std::uint64_t>(part.height);
    std::uint64_t chunks = 0, chunk_pixels = 0, row_pixels = 0;
    if (tiled) {
      if (!layout.tile || (*layout.tile)[0] == 0 || (*layout.tile)[1] == 0) fail(at_, "a tiled part has no tile size");
      const std::uint64_t across = (*layout.tile)[0], down = (*layout.tile)[1];
      if (std::max(across, down) > kLargestSide_px)
        fail(at_, fmt::format("tiles of {}x{} pixels; each side must be from 1 to {}", across, down, kLargestSide_px));
      chunks = ((width + across - 1) / across) * ((height + down - 1) / down);
      chunk_pixels = across * down;
      row_pixels = width * std::min(down, height);
    } else {
      const std::uint64_t rows = rowsOfChunk(*layout.compression);
      if (rows == 0) fail(at_, fmt::format("compression {} is unknown", *layout.compression));
      chunks = (height + rows - 1) / rows;
      chunk_pixels = width * rows;
    }
    chunks_ += std::max(chunks, layout.claimed_chunks);
    part.buffer_bytes = (kCopies * chunk_pixels + row_pixels) * layout.pixel_bytes;
  }

  template <class T>
  T number(std::uint64_t at) const {
    std::array<std::byte, sizeof(T)> raw;
    if (at > bytes_.size || sizeof(T) > bytes_.size - at) fail(at, "the file ends too early");
    bytes_.copy(at, raw);
    return std::bit_cast<T>(raw);
  }
  template <class T>
  T take() {
    const T value = number<T>(at_);
    at_ += sizeof(T);
    return value;
  }
  std::uint64_t takeLength(std::uint64_t end) {
    const auto length = take<std::int32_t>();
    if (length < 0 || at_ > end || static_cast<std::uint64_t>(length) > end - at_)
      fail(at_ - 4, fmt::format("a length of {} is more than its value holds", length));
    return static_cast<std::uint64_t>(length);
  }
  void skip(std::uint64_t count) {
    if (count > bytes_.size - at_) fail(at_, "the file ends too early");
    at_ += count;
  }
  // Reads a text up to a 0 byte. OpenEXR's names have at most 255 bytes.
  std::string text() {
    constexpr std::size_t kMost = 256;
    std::string out(static_cast<std::size_t>(std::min<std::uint64_t>(kMost, bytes_.size - at_)), '\0');
    bytes_.copy(at_, std::as_writable_bytes(std::span(out)));
    const std::size_t end = out.find('\0');
    if (end == std::string::npos) fail(at_, "a name is not terminated");
    at_ += end + 1;
    out.resize(end);
    return out;
  }
  [[noreturn]] void fail(std::uint64_t at, const std::string& what) const {
    throw Error(ErrorCode::kFormat, path_, fmt::format("byte {}", at), "cannot be read as OpenEXR: " + what);
  }

  const ExrBytes& bytes_;
  const std::filesystem::path& path_;
  std::uint64_t at_ = 0, chunks_ = 0;
};

}  // namespace

ExrBytes exrBytesOf(std::span<const std::byte> data) {
  return {data.size(), [data](std::uint64_t at, std::span<std::byte> out) {
            std::copy_n(data.begin() + static_cast<std::ptrdiff_t>(at), out.size(), out.begin());
          }};
}

std::vector<ExrPart> readExrHead(const ExrBytes& bytes, const std::filesystem::path& path) {
  return HeadWalk(bytes, path).run();
}

}  // namespace kiln
