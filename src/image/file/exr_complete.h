// Tests that OpenEXR wrote every row of a file. Internal, not installed.
#pragma once

#include <new>

namespace kiln {

/// OpenEXR 3.1 stops without an exception at a block whose compression failed in a thread, as zlib does without memory.
/// requires: rows in increasing order. throws: std::bad_alloc.
template <class File>
void requireAllRows(const File& file) {
  if (file.currentScanLine() != file.header().dataWindow().max.y + 1) throw std::bad_alloc();
}

}  // namespace kiln
