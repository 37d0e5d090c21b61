// The report for readers: a single page without network, scripts or other files.
#pragma once

#include <string>

#include "bench/measurements.h"

namespace kiln {

/// shape: UTF-8, every element closed, every picture embedded.
std::string measurementsHtml(const Measurements& m);

}  // namespace kiln
