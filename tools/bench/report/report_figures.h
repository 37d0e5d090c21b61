// The report's figures as HTML: inline drawings and base64 pictures, so that the page needs no other files.
#pragma once

#include <string>

#include "bench/measurements.h"
#include "bench/report/charts.h"

namespace kiln {

/// Figure 7.
std::string nodeSliceFigures(const Measurements& m);
/// Figure 8: times relative to the range tree's, with the paper's values as marks. Empty if the suite has no range
/// tree.
std::string relativeTimesFigure(const Measurements& m);
/// Figures 9 and 10: the pictures of one projection.
std::string picturesFigure(const Measurements& m, Projection projection, std::string_view number);
/// Figure 11, with the scale of its colours.
std::string artifactFigures(const Measurements& m);
/// The costs, shown beside Table 4.
std::string costFigure(const Measurements& m);

/// Figure 8 as a drawing, for files.
Svg relativeTimesChart(const Measurements& m, Projection projection);

}  // namespace kiln
