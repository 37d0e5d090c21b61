// The geometry of a NIfTI file in world space.
#pragma once

#include "ingest/nifti/nifti_header.h"
#include "ingest/source/volume_source.h"

namespace kiln {

/// Returns the number of volumes in the file: times of a series.
/// throws: Error kFormat, kUnsupported (fewer than three dimensions, several values a voxel).
std::int64_t niftiTimes(const NiftiHeader& header);

/// Returns the geometry of one volume of the file, with the spacing of `options` if the header has no affine. `notes`
/// gets a sentence for each impossible value that is replaced: a spacing that is not above 0, an sform without volume.
/// throws: Error kFormat, kUsage if --spacing does not apply.
VolumeGeometry niftiGeometry(const NiftiHeader& header, const SourceOptions& options, std::vector<std::string>& notes);

}  // namespace kiln
