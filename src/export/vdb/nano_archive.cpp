// Grids of OpenVDB as a file of NanoVDB, by NanoVDB's library. Source: Museth 2021.
// Cost. Compiling takes a quarter of a minute, so that this file alone includes the library.
#include "base/error.h"
#include "export/vdb/export_vdb.h"
#include "export/vdb/grid_archive.h"

#ifdef KILN_NANOVDB

#include <ostream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/memory/memory.h"
#define NANOVDB_USE_ZIP
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>

namespace kiln {
namespace {

using Handle = nanovdb::GridHandle<nanovdb::HostBuffer>;

// Converts the grid if its type is `Grid`.
template <class Grid>
bool convertedFrom(const openvdb::GridBase::Ptr& grid, Handle& out) {
  const auto typed = openvdb::gridPtrCast<Grid>(grid);
  if (!typed) return false;
  out = nanovdb::openToNanoVDB<nanovdb::HostBuffer, typename Grid::TreeType>(*typed);
  return true;
}

// The types of grids that an export makes.
Handle converted(const openvdb::GridBase::Ptr& grid) {
  requireMemory(grid->memUsage());  // the library does not check its allocation
  Handle out;
  if (!convertedFrom<openvdb::FloatGrid>(grid, out) && !convertedFrom<openvdb::Vec3fGrid>(grid, out) &&
      !convertedFrom<openvdb::Int32Grid>(grid, out) && !convertedFrom<openvdb::Int64Grid>(grid, out) &&
      !convertedFrom<openvdb::DoubleGrid>(grid, out))
    throw std::logic_error("a grid of a type that is not exported: " + grid->type());
  return out;
}

class NanoVdbArchive final : public GridArchive {
 public:
  explicit NanoVdbArchive(bool compress) : compress_(compress) {}

  void write(const openvdb::GridPtrVec& grids, std::ostream& file) const override {
    std::vector<Handle> handles;
    for (const openvdb::GridBase::Ptr& grid : grids) handles.push_back(converted(grid));
    nanovdb::io::writeGrids<nanovdb::HostBuffer, std::vector>(
        file, handles, compress_ ? nanovdb::io::Codec::ZIP : nanovdb::io::Codec::NONE);
  }
  const char* name() const override { return compress_ ? "NanoVDB by zlib" : "NanoVDB"; }
  // The grid of NanoVDB beside the grid of OpenVDB; zlib compresses to a buffer of the whole grid.
  std::uint64_t copies() const override { return compress_ ? 3 : 2; }

 private:
  bool compress_;
};

}  // namespace

const GridArchive& nanoVdbArchive(bool compress) {
  static const NanoVdbArchive plain(false), compressed(true);
  return compress ? compressed : plain;
}

}  // namespace kiln

#else

namespace kiln {

const GridArchive& nanoVdbArchive(bool /*compress*/) {
  throw Error(ErrorCode::kUnsupported, {}, "",
              "NanoVDB files cannot be written, because Kiln was built without NanoVDB (Debian: libnanovdb-dev)");
}

}  // namespace kiln

#endif
