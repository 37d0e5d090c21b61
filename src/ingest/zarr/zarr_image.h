// Finds the volume that a folder of Zarr or N5 holds: an array, the scales of an OME-Zarr or N5 image, or one image
// among several.
#pragma once

#include "ingest/chunks/array_volume.h"
#include "ingest/zarr/zarr_array.h"

namespace kiln {

struct ZarrImage {
  ZarrArray array;
  ArrayVolume volume;
  /// The files that describe the image, the group's first.
  std::vector<std::filesystem::path> headers;
};

/// throws: Error kUsage, listing the images, if there are several, or an option does not apply; kUnsupported if there
/// is no volume (plates, arrays of one axis, transformations that are not read); kFormat, kIo.
ZarrImage openZarrImage(const std::filesystem::path& folder, const SourceOptions& options);

}  // namespace kiln
