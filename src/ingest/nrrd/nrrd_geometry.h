// Where the voxels of a NRRD file are in the world.
#pragma once

#include "ingest/source/header_text.h"

namespace kiln {

/// The geometry that the fields give, with the spacing of `options` where they give no directions.
/// throws: Error kFormat, kUnsupported (a space that is not of three dimensions, or has time), kUsage where --spacing
/// does not apply.
VolumeGeometry nrrdGeometry(const HeaderFields& fields, const SourceOptions& options);

}  // namespace kiln
