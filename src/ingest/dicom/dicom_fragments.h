// Finds the fragments of each compressed frame; a frame has one or more fragments.
#pragma once

#include "base/file/file.h"

namespace kiln {

/// A part of a file. unit: bytes.
struct ByteRange {
  std::uint64_t offset = 0, size = 0;
};

/// Returns the byte ranges of each of `frames` compressed frames, whose fragments begin at `offset_bytes`.
/// throws: Error kFormat if fragments are missing; kUnsupported if fragments cannot be assigned to frames.
std::vector<std::vector<ByteRange>> dicomFragments(const File& file, std::uint64_t offset_bytes, std::size_t frames);

}  // namespace kiln
