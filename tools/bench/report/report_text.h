// Summaries as text for the terminal: the numbers of Tables 2 and 3, with the paper's numbers in brackets.
#pragma once

#include <string>

#include "bench/measurements.h"

namespace kiln {

/// Returns a heading "HEAD 256x256 orthographic" and an indented line for each method.
std::string runText(const Measurements& m, const MeasuredRun& run);
/// Returns the ranking of the methods with their speed-ups.
std::string standingsText(const Measurements& m);

}  // namespace kiln
