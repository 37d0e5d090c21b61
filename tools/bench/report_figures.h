// The report's figures as HTML: drawings inline, pictures as base64, so that the page needs nothing beside it.
#pragma once

#include <string>

#include "bench/charts.h"
#include "bench/measurements.h"

namespace kiln {

/// Figure 7.
std::string nodeSliceFigures(const Measurements& m);
/// Figure 8: times relative to the range tree's, the paper's beside them. Empty where the suite has no range tree.
std::string relativeTimesFigure(const Measurements& m);
/// Figures 9 and 10: the pictures of one projection.
std::string picturesFigure(const Measurements& m, Projection projection, std::string_view number);
/// Figure 11 with the scale of its colours.
std::string artifactFigures(const Measurements& m);
/// Beside Table 4.
std::string costFigure(const Measurements& m);

/// Figure 8 and the charts of costs by themselves, for files.
Svg relativeTimesChart(const Measurements& m, Projection projection);

}  // namespace kiln
