// The chunks of an HDF5 data set: read and decoded by Kiln on all threads, or by processes of the HDF5 library.
#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "base/file/file.h"
#include "ingest/bytes/handle_pool.h"
#include "ingest/hdf5/hdf5_layout.h"

namespace kiln {

/// Opens the chunks of `layout`; `layout.table` or the library finds the chunks. throws: Error kNotFound, kIo.
std::unique_ptr<ChunkedArray> openHdf5Chunks(const std::filesystem::path& file, Hdf5Layout layout);

}  // namespace kiln
