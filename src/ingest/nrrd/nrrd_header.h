// The text header of a NRRD file as fields, each under one name however the file spells it.
#pragma once

#include "ingest/source/header_text.h"

namespace kiln {

struct NrrdHeader {
  HeaderFields fields;
  /// End of the header's last line. unit: bytes.
  std::uint64_t end_offset = 0;
  /// True if the header ends with the empty line that must precede attached data.
  bool closed = false;
  /// The names behind "data file: LIST".
  std::vector<std::string> listed;
};

/// throws: Error kFormat if the file is not NRRD, or a line is not a NRRD field; kUnsupported for a later version.
NrrdHeader readNrrdHeader(const File& file);

}  // namespace kiln
