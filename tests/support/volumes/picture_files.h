// PNG and JPEG files for the tests of the readers: PNG put together chunk by chunk, JPEG by libjpeg.
#pragma once

#include <string>

#include "support/volumes/foreign_files.h"

namespace kiln::test {

/// Returns a chunk of PNG with its length and checksum.
std::string pngChunk(const std::string& name, const std::string& data);
/// `rows` are packed rows of pixels, big-endian, without filter bytes; `more` are chunks in front of the pixels.
std::string pngFile(int width, int height, int depth, int colour, const std::string& rows,
                    const std::string& more = "");
/// Returns slice `z` as a grey PNG file.
std::string pngSlice(const ForeignVolume& volume, std::int64_t z);
/// Returns a JPEG file of quality 100, which keeps blocks of 8 x 8 equal pixels exactly.
std::string jpegFile(int width, int height, int components, const std::string& pixels);

}  // namespace kiln::test
