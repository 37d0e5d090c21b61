// The geometry of a NRRD file in world space.
#pragma once

#include "ingest/source/header_text.h"

namespace kiln {

/// Returns the geometry of the fields in the unit of x, with the spacing of `options` if the header has no directions.
/// throws: Error kFormat, kUnsupported (a space that is not three-dimensional, or has time), kUsage if --spacing
/// does not apply.
VolumeGeometry nrrdGeometry(const HeaderFields& fields, const SourceOptions& options, std::vector<std::string>& notes);

}  // namespace kiln
