// The paper's tables with measured numbers, and the paper's numbers in lighter columns, as HTML.
#pragma once

#include <string>

#include "bench/measurements.h"

namespace kiln {

/// shape: each table is a <figure class="table"> with its caption.
std::string dataTable(const Measurements& m);          // Table 1
std::string standingsTable(const Measurements& m);     // no counterpart in the paper
std::string observationsTable(const Measurements& m);  // of the paper's §3.2; empty if nothing can be compared
/// Tables 2 and 5(a), 3 and 5(b), for one method. `number` is the caption's: "2(a)".
std::string visitsTable(const Measurements& m, VisibilityMethod method, std::string_view number);
std::string timesTable(const Measurements& m, VisibilityMethod method, std::string_view number);
/// Table 4: complexities, and costs measured at the smallest and the largest image.
std::string complexityTable(const Measurements& m);
/// Histogram of pixel distances; the smallest sufficient ε and its cost; results and costs of every ε.
std::string histogramTable(const Measurements& m);
std::string enoughTable(const Measurements& m);
std::string epsilonTable(const Measurements& m, const ArtifactStudy& study);

}  // namespace kiln
