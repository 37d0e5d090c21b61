#include "bench/report/charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace kiln {
namespace {

// Maps values to pixels along an axis.
struct Scale {
  bool log = false;
  double lo = 0, hi = 1, from_px = 0, to_px = 1;

  double operator()(double v) const {
    const double t = log ? std::log(v / lo) / std::log(hi / lo) : (v - lo) / (hi - lo);
    return from_px + t * (to_px - from_px);
  }
};

// Returns 1, 2, 5, 10, …; more ticks on a short axis, powers of ten only on a long axis.
std::vector<double> logTicks(double lo, double hi) {
  std::vector<double> out;
  const bool crowded = hi / lo > 3000, roomy = hi / lo < 10;
  for (double decade = std::pow(10, std::floor(std::log10(lo))); decade <= hi * 1.0001; decade *= 10) {
    for (const double factor : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0}) {
      const double v = decade * factor;
      if (crowded && factor != 1) continue;
      if (!roomy && factor != 1 && factor != 2 && factor != 5) continue;
      if (v >= lo * 0.9999 && v <= hi * 1.0001) out.push_back(v);
    }
  }
  return out;
}

double niceStep(double range, int most) {
  const double rough = range / most;
  const double decade = std::pow(10, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (decade * factor >= rough) return decade * factor;
  return decade * 10;
}

std::vector<double> linearTicks(double hi) {
  std::vector<double> out;
  const double step = niceStep(hi, 6);
  for (int i = 0; i * step <= hi * 1.0001; ++i) out.push_back(i * step);
  return out;
}

struct Bounds {
  double lo = std::numeric_limits<double>::infinity(), hi = -std::numeric_limits<double>::infinity();
  void include(double v) {
    lo = std::min(lo, v);
    hi = std::max(hi, v);
  }
};

Scale scaleFor(const Bounds& bounds, bool log, double from_px, double to_px) {
  Scale out{log, bounds.lo, bounds.hi, from_px, to_px};
  if (log) {
    out.lo = std::min(bounds.lo, bounds.hi / 2) * 0.8;
    out.hi = bounds.hi * 1.25;
  } else {
    out.lo = std::min(0.0, bounds.lo);
    out.hi = bounds.hi > out.lo ? out.lo + (bounds.hi - out.lo) * 1.05 : out.lo + 1;
  }
  return out;
}

// Writes names at the ends of lines, pushed apart where they would overlap.
void writeNames(Svg& svg, std::vector<std::pair<double, const ChartLine*>> names, double x) {
  constexpr double kApart = 14;
  std::sort(names.begin(), names.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 1; i < names.size(); ++i) names[i].first = std::max(names[i].first, names[i - 1].first + kApart);
  for (const auto& [y, line] : names) svg.text({x, y + 4}, "start", line->name, line->classes);
}

}  // namespace

Svg drawLines(const LineChart& chart) {
  constexpr double kWidth = 372, kHeight = 290, kLeft = 54, kRight = 78, kTop = 14, kBottom = 46;
  Svg svg(kWidth, kHeight, chart.label);
  const auto drawable = [&](const SvgPoint& p) { return (!chart.log_x || p.x > 0) && (!chart.log_y || p.y > 0); };
  Bounds x_bounds, y_bounds;
  for (const ChartLine& line : chart.lines) {
    for (const SvgPoint& p : line.points) {
      if (!drawable(p)) continue;
      x_bounds.include(p.x);
      y_bounds.include(p.y);
    }
  }
  if (x_bounds.lo > x_bounds.hi) return svg;
  Scale x{chart.log_x, x_bounds.lo, x_bounds.hi > x_bounds.lo ? x_bounds.hi : x_bounds.lo + 1, kLeft + 8,
          kWidth - kRight};
  const Scale y = scaleFor(y_bounds, chart.log_y, kHeight - kBottom, kTop);
  for (const double tick : chart.log_y ? logTicks(y.lo, y.hi) : linearTicks(y.hi)) {
    svg.line({kLeft, y(tick)}, {kWidth - kRight, y(tick)}, "grid");
    svg.text({kLeft - 6, y(tick) + 4}, "end", fmt::format("{:g}", tick), "small");
  }
  for (const double tick : chart.x_ticks) {
    if ((chart.log_x && tick <= 0) || tick < x.lo || tick > x.hi) continue;
    svg.line({x(tick), kHeight - kBottom}, {x(tick), kHeight - kBottom + 4}, "axis");
    svg.text({x(tick), kHeight - kBottom + 17}, "middle", fmt::format("{:g}", tick), "small");
  }
  svg.line({kLeft, kHeight - kBottom}, {kWidth - kRight, kHeight - kBottom}, "axis");
  svg.text({(kLeft + kWidth - kRight) / 2, kHeight - 8}, "middle", chart.x_title);
  svg.uprightText({14, (kTop + kHeight - kBottom) / 2}, "middle", chart.y_title);
  std::vector<std::pair<double, const ChartLine*>> names;
  for (const ChartLine& line : chart.lines) {
    std::vector<SvgPoint> drawn;
    for (const SvgPoint& p : line.points)
      if (drawable(p)) drawn.push_back({x(p.x), y(p.y)});
    if (drawn.empty()) continue;
    svg.polyline(drawn, line.classes);
    for (const SvgPoint& p : drawn) svg.circle(p, 2.6, line.classes);
    names.emplace_back(drawn.back().y, &line);
  }
  writeNames(svg, names, kWidth - kRight + 8);
  return svg;
}

Svg drawBars(const BarChart& chart) {
  constexpr double kBar = 11, kGap = 16, kHeight = 300, kLeft = 52, kTop = 40, kBottom = 48;
  std::size_t bars = 0;
  double highest = 1;
  for (const BarGroup& group : chart.groups) {
    bars += group.bars.size();
    for (const ChartBar& bar : group.bars) highest = std::max({highest, bar.value, bar.published.value_or(0)});
  }
  // A group is at least as wide as its name.
  constexpr double kName = 88;
  double width = kLeft + kGap;
  for (const BarGroup& group : chart.groups)
    width += std::max(kName, kBar * static_cast<double>(group.bars.size())) + kGap;
  Svg svg(width, kHeight, chart.label);
  const Scale y{false, 0, highest * 1.05, kHeight - kBottom, kTop};
  for (const double tick : linearTicks(y.hi)) {
    svg.line({kLeft, y(tick)}, {width, y(tick)}, "grid");
    svg.text({kLeft - 6, y(tick) + 4}, "end", fmt::format("{:g}", tick), "small");
  }
  svg.uprightText({14, (kTop + kHeight - kBottom) / 2}, "middle", chart.y_title);
  double at = kLeft + kGap;
  for (const BarGroup& group : chart.groups) {
    const double own = kBar * static_cast<double>(group.bars.size());
    const double whole = std::max(kName, own);
    double left = at + (whole - own) / 2;
    for (const ChartBar& bar : group.bars) {
      svg.rect(left, y(bar.value), kBar - 1.5, y(0) - y(bar.value), bar.classes);
      if (bar.published) svg.circle({left + kBar / 2 - 0.75, y(*bar.published)}, 3, "published");
      left += kBar;
    }
    svg.text({at + whole / 2, kHeight - kBottom + 17}, "middle", group.name, "small");
    svg.text({at + whole / 2, kHeight - kBottom + 32}, "middle", group.detail, "small faint");
    at += whole + kGap;
  }
  svg.line({kLeft, y(0)}, {width, y(0)}, "axis");
  svg.line({kLeft, y(1)}, {width, y(1)}, "unit");
  double legend = kLeft;
  for (const auto& [name, classes] : chart.legend) {
    if (classes == "published")
      svg.circle({legend + 5, 17}, 3, classes);
    else
      svg.rect(legend, 12, 10, 10, classes);
    svg.text({legend + 16, 21}, "start", name);
    legend += 34 + 7.0 * static_cast<double>(name.size());
  }
  return svg;
}

}  // namespace kiln
