// The boxes and the size are parsed here, so OpenJPEG gets files of known kinds and sizes only. It decodes some files
// whose tiles are cut short or missing, with grey in their stead, so the parts of tiles are followed, too.
// Source: ITU-T T.800, A.4.2 and A.5.1 (codestream), I.4 and I.5 (boxes).
#include "ingest/pictures/jpeg2000_slice.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "base/error.h"
#include "base/file/file.h"
#include "base/module.h"
#include "ingest/bytes/jpeg2000_size.h"
#include "ingest/pictures/openjpeg_protocol.h"

namespace kiln {
namespace {

constexpr int kMostBoxes = 1024;

[[noreturn]] void failJpeg2000(const std::filesystem::path& path, std::uint64_t at, const std::string& what) {
  throw Error(ErrorCode::kFormat, path, fmt::format("byte {}", at), what + "; the file is cut short or damaged");
}

/// Reads big-endian numbers of a file.
class BoxBytes {
 public:
  explicit BoxBytes(const File& file) : file_(file) {}
  std::uint64_t number(std::uint64_t at, std::size_t bytes) const {
    std::array<std::byte, 8> read{};
    const std::span<std::byte> part = std::span(read).first(bytes);
    if (file_.readSomeAt(at, part) < bytes) failJpeg2000(file_.path(), at, "a box ends too early");
    std::uint64_t out = 0;
    for (const std::byte byte : part) out = out << 8 | std::to_integer<std::uint64_t>(byte);
    return out;
  }

  struct Box {
    std::uint64_t kind = 0, begin = 0, end = 0;
  };
  /// Returns the box at `at`, whose contents end at `limit` or before.
  Box box(std::uint64_t at, std::uint64_t limit) const {
    std::uint64_t length = number(at, 4), head = 8;
    const std::uint64_t kind = number(at + 4, 4);
    if (length == 1) length = number(at + 8, 8), head = 16;
    if (length == 0) length = limit - at;
    if (length < head || length > limit - at)
      failJpeg2000(file_.path(), at, fmt::format("a box of {} bytes lies in {}", length, limit - at));
    return {kind, at + head, at + length};
  }

 private:
  const File& file_;
};

struct Jpeg2000Stream {
  bool in_boxes = false;
  std::uint64_t begin = 0, end = 0;
};

// A palette makes colours of one component.
void requireNoPalette(const File& file, const BoxBytes& bytes, const BoxBytes::Box& header) {
  constexpr std::uint64_t kPalette = 0x70636c72;  // pclr
  int boxes = 0;
  for (std::uint64_t at = header.begin; at < header.end && ++boxes < kMostBoxes;) {
    const BoxBytes::Box box = bytes.box(at, header.end);
    if (box.kind == kPalette)
      throw Error(ErrorCode::kUnsupported, file.path(), "", "holds numbers of a palette, not values; save it as grey");
    at = box.end;
  }
}

Jpeg2000Stream codestreamIn(const File& file) {
  constexpr std::uint64_t kSignature = 0x6a502020, kHeader = 0x6a703268, kCodestream = 0x6a703263;  // jP, jp2h, jp2c
  const BoxBytes bytes(file);
  if (bytes.number(4, 4) != kSignature) return {false, 0, file.size()};
  int boxes = 0;
  for (std::uint64_t at = 0; at < file.size() && ++boxes < kMostBoxes;) {
    const BoxBytes::Box box = bytes.box(at, file.size());
    if (box.kind == kHeader) requireNoPalette(file, bytes, box);
    if (box.kind == kCodestream) return {true, box.begin, box.end};
    at = box.end;
  }
  failJpeg2000(file.path(), 0, "has no codestream");
}

/// Follows the segments of a codestream and the parts of its tiles, from the first byte to the mark of its end.
class TileWalk {
 public:
  TileWalk(const std::filesystem::path& path, std::span<const std::byte> codestream)
      : path_(path), bytes_(codestream) {}

  void requireAllTiles() {
    constexpr std::uint64_t kTilePart = 0xff90, kEnd = 0xffd9, kLeastPart = 14;
    std::vector<bool> seen(tiles());
    std::size_t at = 2;
    for (std::uint64_t marker = number(at, 2); marker != kEnd; marker = number(at, 2)) {
      if (marker < 0xff00) failJpeg2000(path_, at, "the codestream has bytes that are no segment");
      if (marker == kTilePart) {
        const std::uint64_t tile = number(at + 4, 2), length = number(at + 6, 4);
        if (tile >= seen.size()) failJpeg2000(path_, at, fmt::format("tile {} is none of {}", tile, seen.size()));
        seen[tile] = true;
        if (length != 0 && length < kLeastPart)
          failJpeg2000(path_, at, fmt::format("a part of a tile has {} bytes", length));
        // The last part may reach to the end mark without a length.
        at = length > 0 ? at + length : std::max(at + kLeastPart, bytes_.size() - 2);
      } else {
        at += 2 + number(at + 2, 2);
      }
    }
    const auto missing = std::find(seen.begin(), seen.end(), false);
    if (missing != seen.end())
      failJpeg2000(path_, at, fmt::format("tile {} of {} has no data", missing - seen.begin(), seen.size()));
  }

 private:
  std::uint64_t number(std::size_t at, std::size_t count) const {
    if (at > bytes_.size() || count > bytes_.size() - at)
      failJpeg2000(path_, bytes_.size(), "the codestream ends before its end mark (EOC)");
    std::uint64_t out = 0;
    for (const std::byte byte : bytes_.subspan(at, count)) out = out << 8 | std::to_integer<std::uint64_t>(byte);
    return out;
  }

  // Along an axis: from the first tile's begin to the image's end.
  std::uint64_t tilesAlong(std::size_t axis) const {
    const std::uint64_t end = number(8 + 4 * axis, 4), size = number(24 + 4 * axis, 4),
                        first = number(32 + 4 * axis, 4);
    if (size == 0 || first >= end) failJpeg2000(path_, 24, "the codestream has no size of tiles");
    return (end - first + size - 1) / size;
  }
  std::uint64_t tiles() const {
    constexpr std::uint64_t kMostTiles = 65535;
    const std::uint64_t across = tilesAlong(0), down = tilesAlong(1);
    if (across > kMostTiles || down > kMostTiles / across)
      failJpeg2000(path_, 24, fmt::format("the codestream has {} x {} tiles; {} are legal", across, down, kMostTiles));
    return across * down;
  }

  const std::filesystem::path& path_;
  std::span<const std::byte> bytes_;
};

struct Jpeg2000Header {
  Jpeg2000Size size;
  Jpeg2000Stream codestream;
};

Jpeg2000Header jpeg2000HeaderOf(const File& file) {
  Jpeg2000Header out;
  out.codestream = codestreamIn(file);
  std::array<std::byte, kJpeg2000SizeBytes> start{};
  const std::size_t got = file.readSomeAt(out.codestream.begin, start);
  const std::optional<Jpeg2000Size> size = jpeg2000SizeAt(std::span(start).first(got));
  if (!size) failJpeg2000(file.path(), out.codestream.begin, "the codestream has no size of an image");
  out.size = *size;
  return out;
}

std::optional<VoxelType> jpeg2000TypeOf(const Jpeg2000Size& size) {
  if (size.bits <= 8) return size.is_signed ? VoxelType::i8 : VoxelType::u8;
  if (size.bits <= 16) return size.is_signed ? VoxelType::i16 : VoxelType::u16;
  return std::nullopt;
}

}  // namespace

PictureHeader readJpeg2000Header(const std::filesystem::path& path) {
  const File file(path);
  const Jpeg2000Size size = jpeg2000HeaderOf(file).size;
  const auto refuse = [&](const std::string& what) { throw Error(ErrorCode::kUnsupported, path, "", what); };
  if (size.components != 1)
    refuse(fmt::format("holds {} components a pixel, not one value; save it as grey", size.components));
  const std::optional<VoxelType> type = jpeg2000TypeOf(size);
  if (!type) refuse(fmt::format("holds values of {} bits; up to 16 are read", size.bits));
  if (size.is_subsampled) refuse("has fewer values than pixels, which is not read");
  return {{static_cast<std::int64_t>(size.columns), static_cast<std::int64_t>(size.rows), *type}, file.size()};
}

std::vector<std::byte> Jpeg2000Decoder::decode(const std::filesystem::path& path, const PictureSlice& slice,
                                               std::uint64_t limit_bytes) {
  const std::vector<std::byte> data = readFile(path, limit_bytes);
  const File file(path);
  const auto [size, codestream] = jpeg2000HeaderOf(file);
  // The file may have changed since its header was read.
  const bool same = static_cast<std::int64_t>(size.columns) == slice.width &&
                    static_cast<std::int64_t>(size.rows) == slice.height && jpeg2000TypeOf(size) == slice.type &&
                    codestream.end <= data.size();
  if (!same) throw Error(ErrorCode::kFormat, path, "", "has changed while it was read");
  TileWalk(path, std::span(data).subspan(codestream.begin, codestream.end - codestream.begin)).requireAllTiles();
  const Jpeg2000Head head{static_cast<std::uint32_t>(size.columns),
                          static_cast<std::uint32_t>(size.rows),
                          static_cast<std::uint32_t>(size.bits),
                          size.is_signed,
                          codestream.in_boxes,
                          0};
  const auto worker = workers_.take(0, [&] {
    const WorkerLimits limits{.memory_bytes = (std::uint64_t{1} << 30) + 16 * slice.bytes() + 4 * limit_bytes,
                              .request_s = 60 + static_cast<int>(slice.bytes() >> 20)};
    return std::make_unique<WorkerProcess>(programBesideModules("kiln_openjpeg_reader", "JPEG 2000 cannot be read"),
                                           "OpenJPEG", limits);
  });
  const WorkerPlace place{path, ""};
  const std::uint64_t bytes = worker->request(place, 0, {std::as_bytes(std::span(&head, 1)), data});
  if (bytes != slice.bytes())
    throw Error(ErrorCode::kFormat, path, "",
                fmt::format("OpenJPEG gives {} bytes of values (expected {})", bytes, slice.bytes()));
  std::vector<std::byte> out(static_cast<std::size_t>(bytes));
  worker->receive(place, out);
  return out;
}

// In the worker: the request, OpenJPEG's copy of its codes, its numbers of 32 bits in two arrays, and the answer.
std::uint64_t Jpeg2000Decoder::decodeBytes(const PictureSlice& slice, std::uint64_t file_bytes) {
  constexpr std::uint64_t kProcessBytes = 4 << 20, kNumberBytes = 8;
  return 2 * file_bytes + static_cast<std::uint64_t>(slice.width * slice.height) * kNumberBytes + slice.bytes() +
         kProcessBytes;
}

}  // namespace kiln
