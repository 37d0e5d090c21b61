// One TIFF file, page by page, through libtiff: what a page holds, where its strips or tiles are, and one of them
// decoded. A file is hostile until it has been read: every length is checked against the file before it is believed.
#pragma once

#include <memory>

#include "base/file.h"
#include "grid/voxel_type.h"

namespace kiln {

/// What one page holds, in blocks: its strips, or its tiles.
struct TiffPage {
  /// Counting from 1; with `directory`, the byte of the page's directory, it names the page for TiffFile::select.
  int number = 0;
  std::uint64_t directory = 0;
  std::int64_t width = 0, height = 0;
  VoxelType type = VoxelType::u8;
  /// The last blocks of a row or column may reach beyond the page; a strip ends with it.
  std::int64_t block_width = 0, block_height = 0;
  bool tiled = false;
  /// Compressed, or with bits in an order that only libtiff undoes.
  bool packed = false;
  /// Whether the values, where not packed, are in the other byte order than the machine's.
  bool swapped = false;
  /// As the tags say: pixels per unit, 0 where there is none; 1 is no unit, 2 an inch, 3 a centimetre.
  double x_resolution = 0, y_resolution = 0;
  int resolution_unit = 2;
  /// As viewers show the page: the tag of 1 to 8, of which 1 is as stored, and whether the smallest value is white.
  int orientation = 1;
  bool smallest_is_white = false;

  std::int64_t blocksAcross() const { return (width + block_width - 1) / block_width; }
  std::int64_t blocksDown() const { return (height + block_height - 1) / block_height; }
  std::uint64_t bytes() const { return static_cast<std::uint64_t>(width * height) * sizeOf(type); }
  /// Of a whole block, decoded.
  std::uint64_t blockBytes() const { return static_cast<std::uint64_t>(block_width * block_height) * sizeOf(type); }
};

/// thread: one at a time.
class TiffFile {
 public:
  /// Opens the file at its first page. Here and in `next`, pages that are smaller copies of others, or masks, are
  /// passed over. throws: Error kNotFound, kIo, kFormat (not a TIFF file, damaged), kUnsupported naming what a page is
  /// (colour, a palette, several samples a pixel, an unknown compression, 12-bit or 64-bit integers).
  explicit TiffFile(const std::filesystem::path& path);
  ~TiffFile();
  TiffFile(const TiffFile&) = delete;
  TiffFile& operator=(const TiffFile&) = delete;

  const File& file() const;
  const TiffPage& page() const { return page_; }
  /// The page's ImageDescription; empty where it has none.
  std::string description() const;
  /// Goes to the next page; false after the last. throws: as the constructor.
  bool next();
  /// Goes back to a page by its number and directory. throws: as the constructor.
  void select(int number, std::uint64_t directory);

  /// Where the bytes of a block begin in the file. requires: the page is not packed. throws: Error kFormat where they
  /// are not all there.
  std::uint64_t blockOffset(std::int64_t block) const;
  /// The values of a block, in the machine's order; a strip may end with the page. throws: Error kFormat, kIo.
  std::vector<std::byte> decodeBlock(std::int64_t block) const;

  /// Throws an Error at the page: "PATH: page 3: WHAT".
  [[noreturn]] void fail(const std::string& what) const;

 private:
  struct Handle;
  void readPage();
  bool advance();
  /// Called after each read of a directory. throws: Error kIo where a read failed, kFormat where `is_read` is false or
  /// where a part of the directory lies beyond the end of the file.
  void checkDirectory(bool is_read) const;
  std::uint64_t rowsBytes(std::int64_t block) const;

  std::unique_ptr<Handle> handle_;
  TiffPage page_;
};

}  // namespace kiln
