// Everything that a run measured, the summaries included, as JSON for programs.
#pragma once

#include <string>

#include "bench/measurements.h"

namespace kiln {

/// The root has "kiln_report": 1, the machine, the suite as it was read, and lists of volumes, runs (frames and
/// summaries, the paper's numbers beside them), standings, artifacts and costs. unit: as the keys' endings say.
std::string measurementsJson(const Measurements& m);

}  // namespace kiln
