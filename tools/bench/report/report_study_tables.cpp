// Tables of the two studies beside the frames: costs of tests and updates, and distances of the quadtree's pictures
// from the exact pictures.
#include <fmt/format.h>

#include <algorithm>

#include "bench/report/report_table_parts.h"
#include "bench/report/report_tables.h"

namespace kiln {
namespace {

// Returns cells with case, image size and projection of a study.
std::string studyCells(const Measurements& m, const ArtifactStudy& study) {
  return fmt::format("<th scope=\"row\">{} {}</th><td>{}</td>", escaped(m.suite.cases[study.case_index].name),
                     textOf(study.size), titleOf(study.projection));
}

}  // namespace

std::string complexityTable(const Measurements& m) {
  struct Complexity {
    VisibilityMethod method;
    std::string_view update, test;
    bool published;
  };
  static constexpr Complexity kComplexities[] = {
      {VisibilityMethod::kRangeTree, "O(p log n log m + log² n)", "O(log² l)", true},
      {VisibilityMethod::kQuadtree, "O(p log m + log n)", "O(1)", true},
      {VisibilityMethod::kOverlay, "O(p log m + log n)", "O(1)", false},
      {VisibilityMethod::kMask, "O(p)", "O((l/8)²) words", false},
  };
  const auto& costs = m.costs;
  if (costs.updates.empty()) return "";
  const auto [least, greatest] =
      std::minmax_element(costs.updates.begin(), costs.updates.end(),
                          [](const UpdateCost& a, const UpdateCost& b) { return a.size_px < b.size_px; });
  const int sizes[] = {least->size_px, greatest->size_px};
  std::string body;
  for (const Complexity& c : kComplexities) {
    std::string update_cells, test_cells;
    for (const int size : sizes) {
      for (const UpdateCost& u : costs.updates)
        if (u.method == c.method && u.size_px == size) update_cells += numberCell(measured(u.ns_per_pixel));
      // The largest area measured in both images.
      const TestCost* largest = nullptr;
      for (const TestCost& t : costs.tests)
        if (t.method == c.method && t.size_px == size && t.area_px <= sizes[0] / 8) largest = &t;
      if (largest) test_cells += numberCell(measured(largest->mixed_ns));
    }
    if (update_cells.empty()) continue;
    const std::string_view paper = c.published ? "paper" : "";
    body += fmt::format(
        "<tr><th scope=\"row\"><span class=\"swatch {}\"></span>{}</th><td class=\"{}\">{}</td>{}"
        "<td class=\"{}\">{}</td>{}</tr>\n",
        classOf(c.method), titleOf(c.method), paper, c.update, update_cells, paper, c.test, test_cells);
  }
  const std::string head = fmt::format(
      "<tr><th rowspan=\"2\">Method</th><th class=\"group\" colspan=\"3\">Update, ns a pixel that closes</th>"
      "<th class=\"group\" colspan=\"3\">Test of up to {}×{} pixels, ns</th></tr><tr><th>complexity</th>"
      "<th class=\"n\">n = {}</th><th class=\"n\">n = {}</th><th>complexity</th><th class=\"n\">n = {}</th>"
      "<th class=\"n\">n = {}</th></tr>",
      sizes[0] / 8, sizes[0] / 8, sizes[0], sizes[1], sizes[0], sizes[1]);
  return tableFigure(
      "Table 4.",
      "Complexities, the paper’s two in lighter type, and what was measured. n is the image’s edge, m the "
      "footprint’s, l the projected area’s, p the number of pixels that a splat closes.",
      head, body);
}

std::string histogramTable(const Measurements& m) {
  static constexpr std::string_view kBins[] = {"0", "≤ 1", "≤ 2", "≤ 3", "≤ 4", "≤ 5", "≤ 6", "≤ 7", "≤ 8", "&gt; 8"};
  std::string head = "<tr><th>Case</th><th>Projection</th><th class=\"n\">ε, px</th>";
  for (std::size_t i = 0; i < std::size(kBins); ++i)
    head +=
        fmt::format("<th class=\"n\"><span class=\"swatch d{}\"></span>{}</th>", std::min<std::size_t>(i, 8), kBins[i]);
  head += "<th class=\"n\">largest</th></tr>";
  std::string body;
  for (const ArtifactStudy& study : m.artifacts) {
    for (std::size_t i = 0; i < study.steps.size(); ++i) {
      if (i != 0 && study.enough != i) continue;
      const EpsilonStep& step = study.steps[i];
      body += "<tr>" + studyCells(m, study);
      body += numberCell(fmt::format("{}", step.epsilon_px));
      for (const std::uint64_t pixels : step.distance.pixels) body += numberCell(counted(static_cast<double>(pixels)));
      body += numberCell(fmt::format("<b>{:.2f}</b>", step.distance.largest)) + "</tr>\n";
    }
  }
  return tableFigure(
      "Histogram.",
      "Pixels of all views by the distance of the quadtree’s picture from the exact one (Euclidean, RGB, 0 to "
      "255 a channel): for ε = 0, and for the smallest ε tried at which no pixel is off by more than 1.",
      head, body);
}

std::string enoughTable(const Measurements& m) {
  std::string body;
  for (const ArtifactStudy& study : m.artifacts) {
    const EpsilonStep& first = study.steps.front();
    body += "<tr>" + studyCells(m, study);
    body += numberCell(fmt::format("{:.2f}", first.distance.largest));
    if (study.enough) {
      const EpsilonStep& step = study.steps[*study.enough];
      body += numberCell(fmt::format("<b>{}</b>", step.epsilon_px)) +
              numberCell(fmt::format("{:.2f}×", step.visited / first.visited)) +
              numberCell(measured(1e3 * first.render_s)) + numberCell(measured(1e3 * step.render_s)) +
              numberCell(fmt::format("<b>{:.2f}×</b>", step.render_s / first.render_s));
    } else {
      body += numberCell(fmt::format("none up to {}", study.steps.back().epsilon_px)) + kNoCell +
              numberCell(measured(1e3 * first.render_s)) + kNoCell + kNoCell;
    }
    body += numberCell(measured(1e3 * study.exact_s)) + numberCell(measured(1e3 * study.baseline_s)) + "</tr>\n";
  }
  return tableFigure(
      "The price of exactness.",
      "The smallest ε tried at which no pixel of any view is off by more than 1, and what it costs against ε = 0.",
      "<tr><th>Case</th><th>Projection</th><th class=\"n\">largest distance, ε = 0</th><th class=\"n\">ε, px</th>"
      "<th class=\"n\">voxels visited</th><th class=\"n\">ms, ε = 0</th><th class=\"n\">ms, this ε</th>"
      "<th class=\"n\">time</th><th class=\"n\">ms, range tree</th><th class=\"n\">ms, octree only</th></tr>",
      body);
}

std::string epsilonTable(const Measurements& m, const ArtifactStudy& study) {
  const std::string head =
      "<tr><th class=\"n\">ε, px</th><th class=\"n\">largest distance</th><th class=\"n\">pixels off by more than "
      "1</th>"
      "<th class=\"n\">voxels visited</th><th class=\"n\">ratio %</th><th class=\"n\">time, ms</th>"
      "<th class=\"n\">speed-up</th><th class=\"n\">time to ε = 0</th></tr>";
  const auto line = [&](const std::string& name, const std::string& distance, const std::string& off, double visited,
                        double seconds, std::string_view classes) {
    return fmt::format("<tr class=\"{}\">", classes) + numberCell(name) + numberCell(distance) + numberCell(off) +
           numberCell(counted(visited)) + numberCell(fmt::format("{:.2f}", 100 * visited / study.baseline_visited)) +
           numberCell(measured(1e3 * seconds)) + numberCell(fmt::format("{:.2f}", study.baseline_s / seconds)) +
           numberCell(fmt::format("{:.2f}", seconds / study.steps.front().render_s)) + "</tr>\n";
  };
  std::string body;
  for (std::size_t i = 0; i < study.steps.size(); ++i) {
    const EpsilonStep& step = study.steps[i];
    std::uint64_t off = 0;
    for (std::size_t bin = 2; bin < step.distance.pixels.size(); ++bin) off += step.distance.pixels[bin];
    body += line(fmt::format("{}", step.epsilon_px), fmt::format("{:.2f}", step.distance.largest),
                 counted(static_cast<double>(off)), step.visited, step.render_s, study.enough == i ? "chosen" : "");
  }
  body += line("range tree", "exact", "0", study.exact_visited, study.exact_s, "rule");
  return tableFigure(fmt::format("{}, {}.", escaped(m.suite.cases[study.case_index].name), titleOf(study.projection)),
                     fmt::format("What an ε gives and costs, {} pixels, {}.", textOf(study.size), viewsText(m.suite)),
                     head, body);
}

}  // namespace kiln
