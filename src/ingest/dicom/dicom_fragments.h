// Compressed pixels lie in fragments, one or more a frame: which bytes are whose.
#pragma once

#include "base/file.h"

namespace kiln {

/// A part of a file. unit: bytes.
struct ByteRange {
  std::uint64_t offset = 0, size = 0;
};

/// Where the bytes of each of `frames` compressed frames lie that begin at `offset_bytes`.
/// throws: Error kFormat where the fragments are not all there; kUnsupported where nothing says whose they are.
std::vector<std::vector<ByteRange>> dicomFragments(const File& file, std::uint64_t offset_bytes, std::size_t frames);

}  // namespace kiln
