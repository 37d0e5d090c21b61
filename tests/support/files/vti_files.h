// Images of VTK in XML: text, and bytes put together by VTK's description of lengths, blocks and base64. The
// compressors are the libraries' own.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "support/files/foreign_files.h"

namespace kiln::test {

struct VtiLayout {
  /// 0 none, 1 zlib, 2 LZ4, 3 LZMA.
  int codec = 0;
  /// "ascii", "binary", "raw" and "base64" (both appended).
  std::string format = "raw";
  bool big = false, wide = false;
  std::size_t block_bytes = 64;
  std::string scalars = " Scalars=\"v\"", kind = "PointData";
  std::string extent, image;
  std::string more_arrays;
};

std::string vtiFile(const ForeignVolume& volume, const VtiLayout& layout = {});
/// Returns a block packed by a codec of VtiLayout other than 0.
std::string vtiBlock(std::string_view bytes, int codec);

}  // namespace kiln::test
