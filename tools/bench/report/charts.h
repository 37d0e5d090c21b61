// The two charts of the report: lines over logarithmic axes, and groups of bars.
#pragma once

#include <functional>
#include <optional>

#include "bench/report/svg.h"

namespace kiln {

struct ChartLine {
  std::string name;
  std::string classes;  // "m-mask"
  std::vector<SvgPoint> points;
};

struct LineChart {
  std::string label, x_title, y_title;
  bool log_x = true, log_y = true;
  std::vector<double> x_ticks;  // positions of the axis marks
  std::vector<ChartLine> lines;
};

/// Writes each line's name at its end. A logarithmic axis omits points without a positive value.
Svg drawLines(const LineChart& chart);

struct ChartBar {
  std::string classes;
  double value = 0;
  std::optional<double> published;  // the paper's value, drawn as a mark
};

struct BarGroup {
  std::string name, detail;  // two lines below the group
  std::vector<ChartBar> bars;
};

struct BarChart {
  std::string label, y_title;
  std::vector<std::pair<std::string, std::string>> legend;  // name, classes
  std::vector<BarGroup> groups;
};

/// Draws bars from 0, with a dashed line at 1.
Svg drawBars(const BarChart& chart);

}  // namespace kiln
