// PNG, JPEG and JPEG 2000 files for the tests of the readers: PNG put together chunk by chunk, JPEG by libjpeg, JPEG
// 2000 by opj_compress.
#pragma once

#include <string>

#include "support/files/foreign_files.h"

namespace kiln::test {

/// Returns a chunk of PNG with its length and checksum.
std::string pngChunk(const std::string& name, const std::string& data);
/// `rows` are packed rows of pixels, big-endian, without filter bytes; `more` are chunks in front of the pixels.
std::string pngFile(int width, int height, int depth, int colour, const std::string& rows,
                    const std::string& more = "");
/// Returns slice `z` as a grey PNG file.
std::string pngSlice(const ForeignVolume& volume, std::int64_t z);
/// Returns a JPEG file of quality 100, which keeps blocks of 8 x 8 equal pixels exactly; of 3 components, two have half
/// the width and height.
std::string jpegFile(int width, int height, int components, const std::string& pixels, bool progressive = false);

struct Jpeg2000Layout {
  /// Of all values; 0 for all bits of the type.
  int bits = 0;
  /// A file of boxes (JP2), or a codestream alone.
  bool boxes = false;
  int components = 1;
  /// Further options of opj_compress; images have at least 4 x 4 pixels for 3 resolutions.
  std::string options = "-n 3";
};
/// Returns slice `z` as a file of JPEG 2000, compressed without loss. Values of further components equal the first.
/// requires: opj_compress (libopenjp2-tools).
std::string jpeg2000Slice(const ForeignVolume& volume, std::int64_t z, const Jpeg2000Layout& layout = {});

}  // namespace kiln::test
