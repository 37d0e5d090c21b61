// Voxels in linear order that are spread over several files, each with equally many slices.
#pragma once

#include "ingest/bytes/linear_source.h"

namespace kiln {

/// Opens the volume of `info` from its data files, in the order of their slices. `files[i]` describes file i, whose
/// extents are `info.geometry.dims` over the number of files along z. `header` is the first of the source's files.
/// throws: Error kFormat if the slices are not a multiple of the files; the errors of openLinear, naming the file.
std::unique_ptr<VolumeSource> openStacked(const std::filesystem::path& header, SourceInfo info,
                                          std::vector<LinearData> files);

/// Returns the extents of the part of a volume in each of `count` files. throws: Error kFormat, naming `header`, if the
/// slices are not a multiple of the files.
Extent3 partOfFile(const Extent3& dims, std::size_t count, const std::filesystem::path& header);

}  // namespace kiln
