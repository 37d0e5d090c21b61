// All measurements of a run and their summaries, as JSON for programs.
#pragma once

#include <string>

#include "bench/measurements.h"

namespace kiln {

/// The root has "kiln_report": 1, the machine, the suite as read, and lists of volumes, runs (frames and summaries,
/// with the paper's numbers), standings, artifacts and costs. unit: given by the endings of the keys.
std::string measurementsJson(const Measurements& m);

}  // namespace kiln
