// A volume in an array of chunks. A box is put together from the chunks that it meets; decoded chunks are cached for
// neighbouring boxes.
#pragma once

#include <memory>

#include "ingest/chunks/array_volume.h"
#include "ingest/chunks/chunked_array.h"

namespace kiln {

/// Opens `volume`, whose axes are those of `array`. `info` has the files, the trees and the begin of the format's name.
/// throws: Error kFormat if sizes overflow. requires: `info.files` is not empty.
std::unique_ptr<VolumeSource> openChunked(SourceInfo info, const ArrayVolume& volume,
                                          std::unique_ptr<ChunkedArray> array);

}  // namespace kiln
