// A histogram for a terminal: a row a range of values, its bar the logarithm of the count, because most of a scan is
// air.
#pragma once

#include <string>

#include "store/manifest/manifest.h"

namespace kiln::tool {

/// Up to 16 lines, each led by `indent`: the values of the row, its bar, its share of all counted voxels and their
/// number. Empty where nothing is counted. `whole` where values are integers, which are then labelled as such.
std::string histogramText(const ValueHistogram& histogram, bool whole, const std::string& indent);

}  // namespace kiln::tool
