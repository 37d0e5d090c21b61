// One TIFF file, page by page, through libtiff: the tags of a page, the positions of its strips or tiles, and decoded
// blocks.
// Invariant: every length is checked against the file before use.
#pragma once

#include <memory>

#include "base/file/file.h"
#include "ingest/bytes/stored_type.h"
#include "ingest/tiff/tiff_kind.h"

namespace kiln {

/// The layout of one page in blocks: strips or tiles.
struct TiffPage {
  /// Page number from 1. Together with `directory`, the byte of the page's directory, it selects the page in
  /// TiffFile::select.
  int number = 0;
  std::uint64_t directory = 0;
  std::int64_t width = 0, height = 0;
  StoredType type = VoxelType::u8;
  /// Tiles of the last row and column may reach beyond the page; the last strip ends with the page.
  std::int64_t block_width = 0, block_height = 0;
  bool tiled = false;
  /// Samples of a stored pixel, of which a page of colours has several; `type` is that of one.
  int samples = 1;
  /// True for compressed pages, for colours, and for bit orders that only libtiff can reverse.
  bool packed = false;
  /// True if the values of an unpacked page are in the opposite byte order of the machine.
  bool swapped = false;
  /// Tags in pixels per unit; 0 without a tag. Unit 1 is none, 2 an inch, 3 a centimetre.
  double x_resolution = 0, y_resolution = 0;
  int resolution_unit = 2;
  /// Tags for viewers: orientation 1 to 8 (1 is as stored), and whether the smallest value is shown white.
  int orientation = 1;
  bool smallest_is_white = false;

  std::int64_t blocksAcross() const { return (width + block_width - 1) / block_width; }
  std::int64_t blocksDown() const { return (height + block_height - 1) / block_height; }
  std::uint64_t bytes() const { return static_cast<std::uint64_t>(width * height) * sizeOf(type); }
  /// Size of a whole block, decoded. unit: bytes.
  std::uint64_t blockBytes() const { return static_cast<std::uint64_t>(block_width * block_height) * sizeOf(type); }
  /// Memory of the decoding of a block: packed bytes, hardly longer than the samples, and the samples. unit: bytes.
  std::uint64_t decodingBytes() const { return 2 * blockBytes() * static_cast<std::uint64_t>(samples); }
  /// True if both pages may be slices of one volume. Their blocks may differ.
  bool isLike(const TiffPage& other) const {
    return width == other.width && height == other.height && type == other.type && samples == other.samples &&
           orientation == other.orientation && smallest_is_white == other.smallest_is_white;
  }
};

/// thread: one at a time.
class TiffFile {
 public:
  /// Opens the file at its first page. The constructor and `next` pass over masks and reduced copies of other pages.
  /// throws: Error kNotFound, kIo, kFormat (not a TIFF file, damaged), kUnsupported naming the kind of page (colour, a
  /// palette, several samples a pixel, an unknown compression, 12-bit integers).
  explicit TiffFile(const std::filesystem::path& path, TiffColours colours = TiffColours::kRefused);
  ~TiffFile();
  TiffFile(const TiffFile&) = delete;
  TiffFile& operator=(const TiffFile&) = delete;

  const File& file() const;
  const TiffPage& page() const { return page_; }
  TiffColours colours() const { return colours_; }
  /// Returns the page's ImageDescription; empty without the tag.
  std::string description() const;
  /// Goes to the next page; false after the last. throws: as the constructor.
  bool next();
  /// Goes back to a page by its number and directory. throws: as the constructor.
  void select(int number, std::uint64_t directory);

  /// Returns the position of a block in the file. requires: the page is not packed. throws: Error kFormat if the
  /// block is not entirely in the file.
  std::uint64_t blockOffset(std::int64_t block) const;
  /// Returns the values of a block in the machine's byte order; the last strip ends with the page. throws: Error
  /// kFormat, kIo.
  std::vector<std::byte> decodeBlock(std::int64_t block) const;

  /// Throws an Error at the page: "PATH: page 3: WHAT".
  [[noreturn]] void fail(const std::string& what) const;

 private:
  struct Handle;
  void readPage();
  bool advance();
  /// Called after each read of a directory. throws: Error kIo if a read failed, kFormat if `is_read` is false or
  /// a part of the directory lies beyond the end of the file.
  void checkDirectory(bool is_read) const;
  /// Size of the samples of a block in the page. unit: bytes.
  std::uint64_t rowsBytes(std::int64_t block) const;

  std::unique_ptr<Handle> handle_;
  TiffColours colours_;
  TiffPage page_;
};

}  // namespace kiln
