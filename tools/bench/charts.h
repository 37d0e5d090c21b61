// The two charts of the report: lines over a logarithmic axis, and groups of bars.
#pragma once

#include <functional>
#include <optional>

#include "bench/svg.h"

namespace kiln {

struct ChartLine {
  std::string name;
  std::string classes;  // "m-mask"
  std::vector<SvgPoint> points;
};

struct LineChart {
  std::string label, x_title, y_title;
  bool log_x = true, log_y = true;
  std::vector<double> x_ticks;  // where the axis is marked
  std::vector<ChartLine> lines;
};

/// The lines' names stand at their ends. Points without a positive value are left out of a logarithmic axis.
Svg drawLines(const LineChart& chart);

struct ChartBar {
  std::string classes;
  double value = 0;
  std::optional<double> published;  // a mark beside ours
};

struct BarGroup {
  std::string name, detail;  // below the group, in two lines
  std::vector<ChartBar> bars;
};

struct BarChart {
  std::string label, y_title;
  std::vector<std::pair<std::string, std::string>> legend;  // name, classes
  std::vector<BarGroup> groups;
};

/// Bars from 0, with a dashed line at 1.
Svg drawBars(const BarChart& chart);

}  // namespace kiln
