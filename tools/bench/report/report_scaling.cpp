#include "bench/report/report_scaling.h"

#include <fmt/format.h>

#include <algorithm>

#include "bench/report/charts.h"
#include "bench/report/report_table_parts.h"

namespace kiln {
namespace {

double longestEdge(const ScalingPoint& p) {
  const Extent3& n = p.volume.dims;
  return static_cast<double>(std::max({n.x, n.y, n.z}));
}
double mebibytes(std::uint64_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

template <class Value>
std::string chart(const Measurements& m, const std::string& label, const std::string& y_title, Value value) {
  LineChart out{label, "longest edge, voxels", y_title, true, true, {}, {}};
  ChartLine line{"mask", classOf(VisibilityMethod::kMask), {}};
  for (const ScalingPoint& p : m.scaling) {
    out.x_ticks.push_back(longestEdge(p));
    line.points.push_back({longestEdge(p), value(p)});
  }
  out.lines.push_back(std::move(line));
  return drawLines(out).inlined();
}

}  // namespace

std::string scalingTable(const Measurements& m) {
  if (m.scaling.empty()) return "";
  const ScalingPoint& smallest = m.scaling.front();
  std::string body;
  for (const ScalingPoint& p : m.scaling) {
    const auto read = static_cast<double>(p.first.bricks_read_bytes);
    const auto contributing = static_cast<double>(p.first.bricks_contributing_bytes);
    body += fmt::format("<tr><th scope=\"row\">{} × {} × {}</th>", p.volume.dims.x, p.volume.dims.y, p.volume.dims.z) +
            numberCell(measured(1e3 * p.render_s)) +
            numberCell(fmt::format("<b>{:.2f}</b>", p.render_s / smallest.render_s)) +
            numberCell(measured(mebibytes(p.memory_bytes))) +
            numberCell(fmt::format("<b>{:.2f}</b>",
                                   static_cast<double>(p.memory_bytes) / static_cast<double>(smallest.memory_bytes))) +
            numberCell(measured(1e3 * p.first_s)) + numberCell(measured(mebibytes(p.first.bricks_read_bytes))) +
            (contributing > 0 ? numberCell(fmt::format("{:.2f}", read / contributing)) : kNoCell) + "</tr>\n";
  }
  return tableFigure(
      "Scaling.",
      fmt::format("One object at several sizes, {} pixels, each region at the level that fits the view. The first "
                  "frame begins with an empty cache; “to contributing” is what it read to the bytes of the bricks of "
                  "which a splat was drawn.",
                  textOf(m.suite.scaling.size)),
      "<tr><th>Voxels</th><th class=\"n\">warm frame, ms</th><th class=\"n\">to the smallest</th>"
      "<th class=\"n\">memory, MiB</th><th class=\"n\">to the smallest</th><th class=\"n\">first frame, ms</th>"
      "<th class=\"n\">read, MiB</th><th class=\"n\">to contributing</th></tr>",
      body);
}

std::string scalingFigure(const Measurements& m) {
  if (m.scaling.empty()) return "";
  const std::string time =
      chart(m, "Warm frame against volume", "warm frame, ms", [](const ScalingPoint& p) { return 1e3 * p.render_s; });
  const std::string memory =
      chart(m, "Memory against volume", "memory, MiB", [](const ScalingPoint& p) { return mebibytes(p.memory_bytes); });
  return fmt::format(
      "<figure><div class=\"panels\"><div class=\"panel\">{}<p>(a) time of a warm frame</p></div>"
      "<div class=\"panel\">{}<p>(b) memory: bricks at their most, image, visibility and index</p></div></div>"
      "<figcaption><b>Growth.</b> Both axes are logarithmic.</figcaption></figure>\n",
      time, memory);
}

}  // namespace kiln
