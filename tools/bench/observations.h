// Tests the observations of Lee and Ihm (§3.2) on the paper's tables and on the suite: how often each holds.
#pragma once

#include <string>
#include <vector>

#include "bench/measurements.h"

namespace kiln {

struct Observation {
  std::string sentence;
  std::size_t comparisons = 0;  // possible in both the paper and the suite
  std::size_t in_paper = 0, here = 0;
};

/// Returns the observations with at least one comparison.
std::vector<Observation> observationsOf(const Measurements& m);

}  // namespace kiln
