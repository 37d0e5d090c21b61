// TIFF files for the tests of the reader, written by libtiff in every layout that libtiff supports.
#pragma once

#include <filesystem>
#include <string>

#include "support/files/foreign_files.h"

namespace kiln::test {

/// Size of stacks in round trips: tiles and strips end in mid-slice.
inline constexpr Extent3 kStackDims = {21, 19, 4};

/// Layout of pages. The default is one strip a page, uncompressed, little-endian.
struct TiffLayout {
  bool big_endian = false, big_tiff = false;
  /// libtiff's codes: 1 none, 5 LZW, 8 Deflate, 32773 PackBits.
  int compression = 1;
  /// 2 stores differences, 3 stores differences of floating-point bytes.
  int predictor = 1;
  /// Rows of a strip; 0 is the whole page.
  int strip_rows = 0;
  /// The edge of a tile, a multiple of 16; 0 writes strips.
  int tile = 0;
  /// 0 white is zero, 1 black is zero, 2 RGB, 3 palette.
  int photometric = 1;
  int samples = 1;
  /// True if the volume holds the samples, those of a pixel one behind the other along x; else samples are zero.
  bool holds_samples = false;
  /// Bits a sample, if different from the type's; the samples are then bytes of zero.
  int bits = 0;
  /// 2 signed integers, 3 floating-point numbers; 0 is the volume's own.
  int sample_format = 0;
  /// Number of pages, from the back, that are marked as smaller copies.
  int reduced_pages = 0;
  std::string description;
  /// Pixels per unit, and the unit: 1 none, 2 inch, 3 centimetre; 0 is not written.
  double x_resolution = 0, y_resolution = 0;
  int resolution_unit = 0;
  /// Rotation of the page by viewers, 1 to 8; 0 is not written.
  int orientation = 0;
};

/// Writes the slices [z0, z1) of `volume` as the pages of a single file.
void writeTiff(const std::filesystem::path& path, const ForeignVolume& volume, std::int64_t z0, std::int64_t z1,
               const TiffLayout& layout = {});

}  // namespace kiln::test
