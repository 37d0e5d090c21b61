// What Lee and Ihm observe in their tables (§3.2), asked of ours: how often each observation holds there and here.
#pragma once

#include <string>
#include <vector>

#include "bench/measurements.h"

namespace kiln {

struct Observation {
  std::string sentence;
  std::size_t comparisons = 0;  // that both the paper and the suite allow
  std::size_t in_paper = 0, here = 0;
};

/// Those with at least one comparison.
std::vector<Observation> observationsOf(const Measurements& m);

}  // namespace kiln
