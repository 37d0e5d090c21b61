// The paper's tables with our numbers, the paper's in lighter columns beside them, as HTML.
#pragma once

#include <string>

#include "bench/measurements.h"

namespace kiln {

/// shape: each a <figure class="table"> with its caption.
std::string dataTable(const Measurements& m);          // Table 1
std::string standingsTable(const Measurements& m);     // no counterpart in the paper
std::string observationsTable(const Measurements& m);  // of the paper's §3.2; empty where nothing compares
/// Tables 2 and 5(a), 3 and 5(b): of one method. `number` is the caption's: "2(a)".
std::string visitsTable(const Measurements& m, VisibilityMethod method, std::string_view number);
std::string timesTable(const Measurements& m, VisibilityMethod method, std::string_view number);
/// Table 4's complexities beside the costs measured at the smallest and the largest image.
std::string complexityTable(const Measurements& m);
/// How many pixels are off by how much; the ε that is enough and its price; what every ε gives and costs.
std::string histogramTable(const Measurements& m);
std::string enoughTable(const Measurements& m);
std::string epsilonTable(const Measurements& m, const ArtifactStudy& study);

}  // namespace kiln
