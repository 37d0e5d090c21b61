// Where the voxels of a NIfTI-1 file are in the world.
#pragma once

#include "ingest/nifti/nifti_header.h"
#include "ingest/source/volume_source.h"

namespace kiln {

/// The geometry that the header gives, with the spacing of `options` where it gives no affine. `notes` gets a sentence
/// for each value that is taken instead of an impossible one: a spacing that is not above 0, an sform without volume.
/// throws: Error kFormat, kUnsupported (other than one volume of three dimensions), kUsage where --spacing does not
/// apply.
VolumeGeometry niftiGeometry(const NiftiHeader& header, const SourceOptions& options, std::vector<std::string>& notes);

}  // namespace kiln
