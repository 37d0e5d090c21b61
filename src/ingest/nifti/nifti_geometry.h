// The geometry of a NIfTI-1 file in world space.
#pragma once

#include "ingest/nifti/nifti_header.h"
#include "ingest/source/volume_source.h"

namespace kiln {

/// Returns the header's geometry, with the spacing of `options` if the header has no affine. `notes` gets a sentence
/// for each impossible value that is replaced: a spacing that is not above 0, an sform without volume.
/// throws: Error kFormat, kUnsupported (anything but one volume of three dimensions), kUsage if --spacing does not
/// apply.
VolumeGeometry niftiGeometry(const NiftiHeader& header, const SourceOptions& options, std::vector<std::string>& notes);

}  // namespace kiln
