// Files of grids: OpenVDB and NanoVDB.
#pragma once

#include <cstdint>
#include <filesystem>

#include "grid/openvdb_glue.h"

namespace kiln {

class GridArchive {
 public:
  virtual ~GridArchive() = default;

  /// Writes all grids to a new file at `path`. throws: exceptions of streams and of the library.
  virtual void write(const openvdb::GridPtrVec& grids, const std::filesystem::path& path) const = 0;
  /// Memory while a file is written, in multiples of the grids' own.
  virtual std::uint64_t copies() const = 0;
};

}  // namespace kiln
