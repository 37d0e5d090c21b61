// A histogram for a terminal: a row a range of values, its bar the logarithm of the count, because most of a scan is
// air.
#pragma once

#include <string>

#include "store/manifest/manifest.h"

namespace kiln::tool {

/// Returns up to 16 lines that begin with `indent`: a range of values, a bar, the share of the counted voxels, and the
/// count. Empty if no voxel is counted. `whole`: values are integers and are printed as such.
std::string histogramText(const ValueHistogram& histogram, bool whole, const std::string& indent);

}  // namespace kiln::tool
