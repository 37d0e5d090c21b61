// The measurements as a table for programs: a line for each case, image size, projection, method and view.
#pragma once

#include <string>

#include "bench/measurements.h"

namespace kiln {

/// RFC 4180, with a line of column names that contain the units. Numbers have a decimal point and no grouping.
std::string measurementsCsv(const Measurements& m);

}  // namespace kiln
