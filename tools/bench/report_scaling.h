// The scaling study as HTML: a table, and time and memory against the number of voxels.
#pragma once

#include <string>

#include "bench/measurements.h"

namespace kiln {

/// Empty where the suite has no such study.
std::string scalingTable(const Measurements& m);
std::string scalingFigure(const Measurements& m);

}  // namespace kiln
