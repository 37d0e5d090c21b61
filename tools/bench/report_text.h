// A run as one line of text, for the terminal: what Tables 2 and 3 say of it, the paper's numbers in brackets.
#pragma once

#include <string>

#include "bench/measurements.h"

namespace kiln {

/// "HEAD 256x256 orthographic: octree only 640 123 voxels, 21.3 ms" and a line for each other method, indented.
std::string runText(const Measurements& m, const MeasuredRun& run);
/// Which method wins, and by how much.
std::string standingsText(const Measurements& m);

}  // namespace kiln
