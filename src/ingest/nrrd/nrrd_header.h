// The text at the front of a NRRD file as fields, each under one name however the file spells it.
#pragma once

#include "ingest/source/header_text.h"

namespace kiln {

struct NrrdHeader {
  HeaderFields fields;
  /// unit: bytes; just after the header's last line.
  std::uint64_t end_offset = 0;
  /// Whether the empty line is there that data may follow.
  bool closed = false;
};

/// throws: Error kFormat where the file is not NRRD, or a line is not a field of it; kUnsupported for a later version.
NrrdHeader readNrrdHeader(const File& file);

}  // namespace kiln
