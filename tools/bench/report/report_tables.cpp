// Rows are cases and image sizes, as in the paper; a case's name spans its sizes.
#include "bench/report/report_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/observations.h"
#include "bench/published.h"
#include "bench/report/report_table_parts.h"
#include "bench/summary.h"

namespace kiln {
namespace {

// True if a case names a row of the paper; otherwise the paper's columns are omitted.
bool hasPaper(const Measurements& m, VisibilityMethod method) {
  return std::any_of(m.runs.begin(), m.runs.end(), [&](const MeasuredRun& run) {
    return publishedVisits(m.suite.cases[run.case_index].paper, run.size, run.projection, method).has_value();
  });
}

std::string groupTitle(const Measurements& m, Projection projection) {
  const std::string fov = projection == Projection::kPerspective ? fmt::format(" (fov {:g}°)", m.suite.fov_deg) : "";
  return std::string(titleOf(projection)) + fov;
}

}  // namespace

std::string dataTable(const Measurements& m) {
  std::string body;
  const bool paper =
      std::any_of(m.suite.cases.begin(), m.suite.cases.end(), [](const SuiteCase& c) { return !c.paper.empty(); });
  for (std::size_t i = 0; i < m.volumes.size(); ++i) {
    const SuiteCase& c = m.suite.cases[i];
    const VolumeSummary& v = m.volumes[i];
    const auto published = publishedData(c.paper);
    body += fmt::format(
        "<tr><th scope=\"row\">{}</th><td>{}</td><td class=\"note\">{}</td>"
        "<td class=\"n\">{}×{}×{}</td><td>{}</td><td class=\"n\">{:.3g} : {:.3g} : {:.3g}</td>",
        escaped(c.name), escaped(c.classification), escaped(std::filesystem::path(c.volume).filename().string()),
        v.dims.x, v.dims.y, v.dims.z, nameOf(v.type), v.spacing.x, v.spacing.y, v.spacing.z);
    if (paper) {
      body += published ? fmt::format("<td class=\"paper\">{}, {}</td>", published->data, published->size)
                        : std::string("<td class=\"paper\">–</td>");
    }
    body += fmt::format("<td class=\"note\">{}</td></tr>\n", escaped(c.note));
  }
  const std::string head = fmt::format(
      "<tr><th>Case</th><th>Classification</th><th>Volume</th><th class=\"n\">Voxels</th><th>Type</th>"
      "<th class=\"n\">Spacing</th>{}<th>{}</th></tr>",
      paper ? "<th class=\"paper\">In the paper</th>" : "", paper ? "How the two differ" : "");
  return tableFigure("Table 1.", paper ? "The data, and what the paper had in their place." : "The data.", head, body);
}

std::string standingsTable(const Measurements& m) {
  std::string body;
  for (const Standing& s : standingsOf(m)) {
    body += fmt::format(
        "<tr><th scope=\"row\"><span class=\"swatch {}\"></span>{}</th><td>{}</td><td class=\"n\"><b>{:.2f}×</b></td>"
        "<td class=\"n\">{:.2f}× to {:.2f}×</td><td class=\"n\">{:.2f} %</td><td class=\"n\">{} of {}</td></tr>\n",
        classOf(s.method), titleOf(s.method), isExact(s.method) ? "exact" : "approximate", s.speed_up, s.least_speed_up,
        s.greatest_speed_up, s.ratio_percent, s.wins, m.runs.size());
  }
  return tableFigure(
      "Standings.",
      "All cases, image sizes and projections together: geometric means of speed-up over octree only and of "
      "the voxels visited.",
      "<tr><th>Method</th><th>Test</th><th class=\"n\">Speed-up</th><th class=\"n\">least to greatest</th>"
      "<th class=\"n\">Voxels visited</th><th class=\"n\">Fastest in</th></tr>",
      body);
}

std::string observationsTable(const Measurements& m) {
  std::string body;
  for (const Observation& o : observationsOf(m)) {
    body += fmt::format("<tr><td>{}</td>", o.sentence) +
            numberCell(fmt::format("{} of {}", o.in_paper, o.comparisons), "paper") +
            numberCell(fmt::format("<b>{} of {}</b>", o.here, o.comparisons)) + "</tr>\n";
  }
  if (body.empty()) return "";
  return tableFigure("Observations.", "What the paper observes of its times, and how often it holds there and here.",
                     "<tr><th>Observation</th><th class=\"n paper\">in the paper</th><th class=\"n\">here</th></tr>",
                     body);
}

std::string visitsTable(const Measurements& m, VisibilityMethod method, std::string_view caption_number) {
  const bool paper = hasPaper(m, method);
  const std::string body = caseRows(m, [&](std::size_t i, const ImageSize& size) {
    std::string out;
    for (const Projection projection : m.suite.projections) {
      const auto own = summaryIn(m, i, size, projection, method);
      if (!own) return std::string();
      const auto theirs = publishedVisits(m.suite.cases[i].paper, size, projection, method);
      if (out.empty()) {
        out += numberCell(counted(summaryIn(m, i, size, projection, VisibilityMethod::kNone)->visited));
        if (paper) out += theirs ? numberCell(counted(static_cast<double>(theirs->octree_only)), "paper") : kNoCell;
      }
      out += numberCell(counted(own->visited)) + numberCell(fmt::format("<b>{:.2f}</b>", own->ratio_percent));
      if (!paper) continue;
      out += theirs ? numberCell(counted(static_cast<double>(theirs->visited)), "paper") +
                          numberCell(fmt::format("{:.2f}", theirs->ratio_percent), "paper")
                    : kNoCell + kNoCell;
    }
    return out;
  });
  std::string first = fmt::format(
      "<tr><th rowspan=\"2\">Classification</th><th rowspan=\"2\">Image</th>"
      "<th class=\"group\" colspan=\"{}\">Octree only</th>",
      paper ? 2 : 1);
  std::string second = "<tr>" + headCell("voxels") + (paper ? headCell("paper", "paper") : "");
  for (const Projection projection : m.suite.projections) {
    first += fmt::format("<th class=\"group\" colspan=\"{}\">{}</th>", paper ? 4 : 2, groupTitle(m, projection));
    second += headCell(titleOf(method)) + headCell("Ratio %");
    if (paper) second += headCell("paper", "paper") + headCell("Ratio %", "paper");
  }
  return tableFigure(fmt::format("Table {}.", caption_number),
                     fmt::format("Voxels visited with the {}, mean of {}, and their ratio to octree only.{}",
                                 wordOf(method), viewsText(m.suite), paper ? "" : " The paper has no such method."),
                     first + "</tr>" + second + "</tr>", body);
}

std::string timesTable(const Measurements& m, VisibilityMethod method, std::string_view caption_number) {
  const bool paper = hasPaper(m, method);
  const std::string body = caseRows(m, [&](std::size_t i, const ImageSize& size) {
    std::string out;
    for (const Projection projection : m.suite.projections) {
      const auto own = summaryIn(m, i, size, projection, method);
      if (!own) return std::string();
      out += numberCell(measured(1e3 * summaryIn(m, i, size, projection, VisibilityMethod::kNone)->render_s)) +
             numberCell(measured(1e3 * own->render_s)) + numberCell(fmt::format("<b>{:.2f}</b>", own->speed_up));
      if (!paper) continue;
      const auto theirs = publishedTimes(m.suite.cases[i].paper, size, projection, method);
      out += theirs ? numberCell(fmt::format("{:.2f}", theirs->octree_only_s), "paper") +
                          numberCell(fmt::format("{:.2f}", theirs->method_s), "paper") +
                          numberCell(fmt::format("{:.2f}", theirs->speed_up), "paper")
                    : kNoCell + kNoCell + kNoCell;
    }
    return out;
  });
  std::string first = "<tr><th rowspan=\"2\">Classification</th><th rowspan=\"2\">Image</th>", second = "<tr>";
  for (const Projection projection : m.suite.projections) {
    first += fmt::format("<th class=\"group\" colspan=\"3\">{}, ms</th>", groupTitle(m, projection));
    if (paper) first += "<th class=\"group paper\" colspan=\"3\">in the paper, s</th>";
    second += headCell("Octree only") + headCell(titleOf(method)) + headCell("Speed‑up");
    if (paper)
      second += headCell("Octree only", "paper") + headCell(titleOf(method), "paper") + headCell("Speed‑up", "paper");
  }
  return tableFigure(fmt::format("Table {}.", caption_number),
                     fmt::format("Rendering times with the {} in milliseconds, mean of {}, and speed-up over octree "
                                 "only.{}",
                                 wordOf(method), viewsText(m.suite),
                                 paper ? fmt::format(" The paper’s times are in seconds, on its {}.", kPublishedMachine)
                                       : std::string(" The paper has no such method.")),
                     first + "</tr>" + second + "</tr>", body);
}

}  // namespace kiln
