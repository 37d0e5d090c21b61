#include "bench/report/report_figures.h"

#include <fmt/format.h>

#include <algorithm>

#include "bench/published.h"
#include "bench/report/base64.h"
#include "bench/report/node_slice_drawing.h"
#include "bench/report/report_words.h"
#include "bench/summary.h"
#include "job/job_names.h"

namespace kiln {
namespace {

// Widths for four pictures, or three drawings, in a row of a full-width page.
constexpr int kPicture_px = 276, kDrawing_px = 372;

std::string image(const std::vector<std::byte>& png, std::string_view alternative, const ImageSize& size,
                  std::string_view classes) {
  return fmt::format("<img class=\"{}\" width=\"{}\" height=\"{}\" alt=\"{}\" src=\"data:image/png;base64,{}\"/>",
                     classes, size.width, size.height, escaped(alternative), base64Of(png));
}

// Returns a panel as wide as its content, so that the caption wraps below. unit: pixels.
std::string panel(const std::string& content, const std::string& caption, int width_px) {
  return fmt::format("<div class=\"panel\" style=\"max-width:{}px\">{}<p>{}</p></div>\n", width_px, content, caption);
}

// Returns a row of panels.
std::string rowOf(const std::string& panels) { return "<div class=\"panels\">\n" + panels + "</div>\n"; }

std::string figure(std::string_view number, std::string_view caption, const std::string& rows) {
  return fmt::format("<figure>{}<figcaption><b>{}</b> {}</figcaption></figure>\n", rows, number, caption);
}

char letterOf(std::size_t i) { return static_cast<char>('a' + i % 26); }

// Returns a line per method, except octree only, through the points returned by `points`.
template <class Points>
std::vector<ChartLine> methodLines(const Measurements& m, Points points) {
  std::vector<ChartLine> out;
  for (const VisibilityMethod method : m.suite.methods) {
    if (method == VisibilityMethod::kNone) continue;
    ChartLine line{std::string(wordOf(method)), classOf(method), points(method)};
    if (!line.points.empty()) out.push_back(std::move(line));
  }
  return out;
}

std::vector<double> ticksOf(const std::vector<int>& values) { return {values.begin(), values.end()}; }

// Returns the paper's time relative to the paper's range tree.
std::optional<double> publishedRelative(const SuiteCase& c, const MeasuredRun& run, VisibilityMethod method) {
  const auto own = publishedTimes(c.paper, run.size, run.projection, method);
  const auto tree = publishedTimes(c.paper, run.size, run.projection, VisibilityMethod::kRangeTree);
  return own && tree ? std::optional(own->method_s / tree->method_s) : std::nullopt;
}

}  // namespace

std::string nodeSliceFigures(const Measurements& m) {
  static constexpr std::string_view kAxes = "xyz";
  std::string rows, panels;
  for (std::size_t i = 0; i < m.slices.size(); ++i) {
    const NodeSlice& slice = m.slices[i];
    const bool baseline = slice.method == VisibilityMethod::kNone;
    panels += panel(drawNodeSlice(slice, m.volumes[slice.case_index]).inlined(),
                    fmt::format("({}) {}, {}{}: {} voxels of the volume visited; slice {} = {}", letterOf(i),
                                escaped(m.suite.cases[slice.case_index].name), wordOf(slice.method),
                                baseline ? "" : fmt::format(", {}", nameIn(kProjectionNames, slice.projection)),
                                counted(static_cast<double>(slice.visited)),
                                kAxes[static_cast<std::size_t>(slice.log.axis)], slice.log.plane),
                    372);
    // Rows as in the paper: octree only and the quadtree, then the mask.
    const bool last = i + 1 == m.slices.size() || m.slices[i + 1].case_index != slice.case_index;
    if (!last && m.slices[i + 1].method != VisibilityMethod::kMask) continue;
    if (!last && slice.method == VisibilityMethod::kMask) continue;
    rows += rowOf(panels);
    panels.clear();
  }
  return figure(
      "Figure 7.",
      "Slices through the octree: its finest nodes that were visited (filled), the nodes above them (outlined), "
      "and nodes found hidden (shaded). The arrow is the direction of view.",
      rows);
}

Svg relativeTimesChart(const Measurements& m, Projection projection) {
  BarChart chart;
  chart.label = fmt::format("Times relative to the range tree, {}", titleOf(projection));
  chart.y_title = "time / range tree’s time";
  bool published = false;
  for (const VisibilityMethod method : m.suite.methods)
    if (method != VisibilityMethod::kNone) chart.legend.emplace_back(wordOf(method), classOf(method));
  for (const MeasuredRun& run : m.runs) {
    if (run.projection != projection) continue;
    const SuiteCase& c = m.suite.cases[run.case_index];
    const auto tree = summaryOf(run, VisibilityMethod::kRangeTree);
    if (!tree) continue;
    BarGroup group{c.name, textOf(run.size), {}};
    for (const VisibilityMethod method : m.suite.methods) {
      if (method == VisibilityMethod::kNone) continue;
      const auto paper = publishedRelative(c, run, method);
      published = published || paper;
      group.bars.push_back({classOf(method), summaryOf(run, method)->render_s / tree->render_s, paper});
    }
    chart.groups.push_back(group);
  }
  if (published) chart.legend.emplace_back("in the paper", "published");
  return drawBars(chart);
}

std::string relativeTimesFigure(const Measurements& m) {
  if (!hasMethod(m, VisibilityMethod::kRangeTree)) return "";
  std::string charts;
  for (const Projection projection : m.suite.projections) {
    charts += fmt::format("<div class=\"wide\"><p class=\"over\">{}</p>{}</div>\n", titleOf(projection),
                          relativeTimesChart(m, projection).inlined());
  }
  return fmt::format(
      "<figure>{}<figcaption><b>Figure 8.</b> Rendering times relative to the range tree’s, which is 1. "
      "Lower is faster.</figcaption></figure>\n",
      charts);
}

std::string picturesFigure(const Measurements& m, Projection projection, std::string_view number) {
  std::string panels;
  std::size_t i = 0;
  for (const Picture& picture : m.pictures) {
    if (picture.projection != projection) continue;
    const SuiteCase& c = m.suite.cases[picture.case_index];
    panels += panel(image(picture.png, c.name, picture.size, "plate"),
                    fmt::format("({}) {}, {}", letterOf(i++), escaped(c.name), textOf(picture.size)), kPicture_px);
  }
  return figure(number,
                fmt::format("The pictures, {} projection, the middle view.",
                            projection == Projection::kOrthographic ? "orthographic" : "perspective"),
                rowOf(panels));
}

std::string artifactFigures(const Measurements& m) {
  static constexpr std::string_view kScale[] = {"0", "1", "2", "3", "4", "5", "6", "7", "≥ 8"};
  std::string scale = "<p class=\"scale\">";
  for (std::size_t i = 0; i < std::size(kScale); ++i)
    scale += fmt::format("<span><span class=\"swatch d{}\"></span>{}</span> ", i, kScale[i]);
  scale += "</p>";
  std::string rows;
  std::size_t i = 0;
  for (const ArtifactStudy& study : m.artifacts) {
    std::string panels;
    const std::string name =
        fmt::format("{}, {}", m.suite.cases[study.case_index].name, nameIn(kProjectionNames, study.projection));
    const auto add = [&](const std::vector<std::byte>& png, const std::string& what, std::string_view classes) {
      panels += panel(image(png, name + ", " + what, study.size, classes),
                      fmt::format("({}) {}: {}", letterOf(i++), escaped(name), what), kPicture_px);
    };
    add(study.exact_png, "range tree", "plate");
    add(study.approximate_png, "quadtree", "plate");
    add(study.difference_png, "difference", "difference");
    if (!study.difference_enough_png.empty())
      add(study.difference_enough_png, fmt::format("difference with ε = {} px", study.steps[*study.enough].epsilon_px),
          "difference");
    rows += rowOf(panels);
  }
  return figure("Figure 11.",
                "What the quadtree’s approximation does, in the view where it does most: Euclidean distance in RGB, 0 "
                "to 255 a channel, in the paper’s colours, linear in between." +
                    scale,
                rows);
}

std::string costFigure(const Measurements& m) {
  if (m.costs.updates.empty()) return "";
  const std::vector<int>& sizes = m.suite.cost.sizes_px;
  const std::vector<int>& areas = m.suite.cost.areas_px;
  LineChart update{"Cost of an update against image size",
                   "image edge n, px",
                   "update, ns a pixel",
                   true,
                   true,
                   ticksOf(sizes),
                   methodLines(m, [&](VisibilityMethod method) {
                     std::vector<SvgPoint> points;
                     for (const UpdateCost& u : m.costs.updates)
                       if (u.method == method) points.push_back({static_cast<double>(u.size_px), u.ns_per_pixel});
                     return points;
                   })};
  // Shows a middle area and a middle image; the JSON has all sizes.
  const int area = areas.empty() ? 0 : areas[areas.size() / 2];
  const int size = sizes[sizes.size() / 2];
  LineChart by_size{"Cost of a test against image size",
                    "image edge n, px",
                    fmt::format("test of {0}×{0} px, ns", area),
                    true,
                    true,
                    ticksOf(sizes),
                    methodLines(m, [&](VisibilityMethod method) {
                      std::vector<SvgPoint> points;
                      for (const TestCost& t : m.costs.tests)
                        if (t.method == method && t.area_px == area)
                          points.push_back({static_cast<double>(t.size_px), t.mixed_ns});
                      return points;
                    })};
  LineChart by_area{"Cost of a test against its area",
                    fmt::format("area’s edge l, px, in an image of {0}×{0}", size),
                    "test, hidden area, ns",
                    true,
                    true,
                    ticksOf(areas),
                    methodLines(m, [&](VisibilityMethod method) {
                      std::vector<SvgPoint> points;
                      for (const TestCost& t : m.costs.tests)
                        if (t.method == method && t.size_px == size)
                          points.push_back({static_cast<double>(t.area_px), t.hidden_ns});
                      return points;
                    })};
  std::string panels;
  panels += panel(drawLines(update).inlined(), "(a) a pixel that closes", kDrawing_px);
  panels += panel(drawLines(by_size).inlined(), "(b) a test anywhere in the image, by image size", kDrawing_px);
  panels += panel(drawLines(by_area).inlined(), "(c) a test that finds everything opaque, by area", kDrawing_px);
  return figure("Measured costs.",
                "The structures alone: a disc of three quarters of the image’s width is closed footprint by footprint "
                "from its middle, then squares are asked about. Both axes are logarithmic.",
                rowOf(panels));
}

}  // namespace kiln
