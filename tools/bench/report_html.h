// The report for people: one page that needs no network, no script and no file beside it.
#pragma once

#include <string>

#include "bench/measurements.h"

namespace kiln {

/// UTF-8, every element closed, every picture inside of it.
std::string measurementsHtml(const Measurements& m);

}  // namespace kiln
