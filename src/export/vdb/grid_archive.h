// Files of grids: OpenVDB and NanoVDB.
#pragma once

#include <cstdint>
#include <ostream>

#include "grid/openvdb_glue.h"

namespace kiln {

class GridArchive {
 public:
  virtual ~GridArchive() = default;

  /// Writes all grids to a stream that throws where writing fails. throws: also the library's exceptions.
  virtual void write(const openvdb::GridPtrVec& grids, std::ostream& file) const = 0;
  /// The format and its compression. Archives of one name write equal files.
  virtual const char* name() const = 0;
  /// Memory while a file is written, in multiples of the grids' own.
  virtual std::uint64_t copies() const = 0;
};

}  // namespace kiln
