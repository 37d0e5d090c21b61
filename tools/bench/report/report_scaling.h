// The scaling study as HTML: a table, and time and memory against the number of voxels.
#pragma once

#include <string>

#include "bench/measurements.h"

namespace kiln {

/// Empty if the suite has no scaling study.
std::string scalingTable(const Measurements& m);
std::string scalingFigure(const Measurements& m);

}  // namespace kiln
