// The measurements as a table for programs: one line for each case, image size, projection, method and view.
#pragma once

#include <string>

#include "bench/measurements.h"

namespace kiln {

/// RFC 4180 with a line of names first; units are in the names. Numbers have a point and no grouping.
std::string measurementsCsv(const Measurements& m);

}  // namespace kiln
