// Writes the page, section by section in the order of the paper's §3. Claims are generated from the numbers, so a suite
// with other results gets other sentences.
#include "bench/report/report_html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/duration_text.h"
#include "base/memory/memory.h"
#include "bench/published.h"
#include "bench/report/report_figures.h"
#include "bench/report/report_scaling.h"
#include "bench/report/report_style.h"
#include "bench/report/report_tables.h"
#include "bench/report/report_words.h"
#include "bench/report/svg.h"
#include "bench/summary.h"
#include "frame/render_frame.h"
#include "job/job_names.h"

namespace kiln {
namespace {

std::string section(std::string_view id, std::string_view title, const std::string& content) {
  return fmt::format("<section id=\"{}\"><h2>{}</h2>\n{}</section>\n", id, title, content);
}

std::string paragraph(const std::string& text, std::string_view classes = "") {
  return fmt::format("<p class=\"{}\">{}</p>\n", classes, text);
}

// Number of frames that should equal octree only, and number of frames that do.
struct Exactness {
  std::size_t frames = 0, identical = 0;
};

Exactness exactnessOf(const Measurements& m) {
  Exactness out;
  for (const MeasuredRun& run : m.runs) {
    for (const FrameMeasurement& f : run.frames) {
      if (f.method == VisibilityMethod::kNone || !isExact(f.method)) continue;
      ++out.frames;
      out.identical += f.identical ? 1 : 0;
    }
  }
  return out;
}

std::string exactnessText(const Measurements& m) {
  const Exactness exact = exactnessOf(m);
  if (exact.frames == 0) return "";
  if (exact.identical == exact.frames) {
    return fmt::format(
        "Every one of the {} pictures drawn with an exact method is bit for bit the picture of octree "
        "only.",
        exact.frames);
  }
  return fmt::format("<b>{} of the {} pictures drawn with an exact method are not those of octree only: a defect.</b>",
                     exact.frames - exact.identical, exact.frames);
}

std::string verdict(const Measurements& m) {
  const std::vector<Standing> standings = standingsOf(m);
  const VisibilityMethod chosen = FrameRequest().visibility.method;
  const auto own =
      std::find_if(standings.begin(), standings.end(), [&](const Standing& s) { return s.method == chosen; });
  if (standings.empty()) return "";
  const Standing& best = standings.front();
  std::string out = fmt::format(
      "The <b>{}</b> wins: {:.2f} times as fast as octree only over {} combination{} of case, image size and "
      "projection (geometric mean; {:.2f}× to {:.2f}×), and the fastest in {} of them.",
      wordOf(best.method), best.speed_up, m.runs.size(), m.runs.size() == 1 ? "" : "s", best.least_speed_up,
      best.greatest_speed_up, best.wins);
  for (const Standing& s : standings) {
    if (s.method == best.method || s.method == VisibilityMethod::kNone) continue;
    out += fmt::format(" The {} reaches {:.2f}×.", wordOf(s.method), s.speed_up);
  }
  if (chosen == best.method) {
    out += " It is Kiln’s default.";
  } else if (own != standings.end()) {
    out += fmt::format(" <b>Kiln’s default is the {}, which does not win this suite.</b>", wordOf(chosen));
  }
  return out + " " + exactnessText(m);
}

std::string head(const Measurements& m) {
  std::string out = fmt::format("<h1>{}</h1>\n", escaped(m.suite.title));
  out += paragraph(fmt::format("Splatting with object- and image-space coherence: the experiments of Lee and Ihm, §3, "
                               "repeated with Kiln {} on {}, {} thread{}, {}.",
                               escaped(m.machine.version), escaped(m.machine.processor),
                               m.suite.threads == 0 ? "all" : std::to_string(m.suite.threads),
                               m.suite.threads == 1 ? "" : "s", escaped(m.time)),
                   "by");
  if (m.suite.quick)
    out += paragraph("A quick run: two views drawn once, one image size a case. Its times are rough.", "warning");
  if (m.machine.assertions)
    out += paragraph("This build checks itself (assertions are on); a release build is faster.", "warning");
  out += paragraph(verdict(m), "lead");
  out +=
      "<nav><a href=\"#standings\">Which method wins</a><a href=\"#data\">Data</a><a href=\"#visited\">Voxels "
      "visited</a><a href=\"#times\">Times</a><a href=\"#overlay\">Overlay</a><a href=\"#costs\">Tests and "
      "updates</a><a href=\"#nodes\">Nodes visited</a><a href=\"#pictures\">Pictures</a><a "
      "href=\"#artifacts\">Artifacts</a><a href=\"#method\">How it was measured</a></nav>\n";
  return out;
}

// Reports projections that show a different part of the volume than the first projection: their ratios refer to another
// baseline than the tables show.
std::string otherBaselines(const Measurements& m) {
  std::string out;
  for (const MeasuredRun& run : m.runs) {
    const MeasuredRun* first = findRun(m, run.case_index, run.size, m.suite.projections.front());
    const auto own = summaryOf(run, VisibilityMethod::kNone), other = summaryOf(*first, VisibilityMethod::kNone);
    if (!own || !other || std::abs(own->visited - other->visited) < 0.001 * other->visited) continue;
    out += fmt::format("{}{} at {} in {} projection: {}", out.empty() ? "" : "; ",
                       escaped(m.suite.cases[run.case_index].name), textOf(run.size),
                       nameIn(kProjectionNames, run.projection), counted(own->visited));
  }
  if (out.empty()) return "";
  return paragraph(
      "A ratio is to octree only in the same projection. Where the other projection shows another part of "
      "the volume, that is another number than the tables’: " +
      out + ".");
}

std::string visitedSection(const Measurements& m) {
  std::string out = paragraph(
      "Visited voxels are interesting ones in the finest nodes asked about that were not found hidden. Columns in "
      "lighter type are the paper’s numbers for the case of the same name.");
  out += otherBaselines(m);
  if (hasMethod(m, VisibilityMethod::kRangeTree)) out += visitsTable(m, VisibilityMethod::kRangeTree, "2(a)");
  if (hasMethod(m, VisibilityMethod::kQuadtree)) out += visitsTable(m, VisibilityMethod::kQuadtree, "2(b)");
  if (hasMethod(m, VisibilityMethod::kMask)) out += visitsTable(m, VisibilityMethod::kMask, "2(c)");
  return out;
}

std::string timesSection(const Measurements& m) {
  std::string out;
  if (hasMethod(m, VisibilityMethod::kRangeTree)) out += timesTable(m, VisibilityMethod::kRangeTree, "3(a)");
  if (hasMethod(m, VisibilityMethod::kQuadtree)) out += timesTable(m, VisibilityMethod::kQuadtree, "3(b)");
  if (hasMethod(m, VisibilityMethod::kMask)) out += timesTable(m, VisibilityMethod::kMask, "3(c)");
  return out + relativeTimesFigure(m);
}

std::string artifactsSection(const Measurements& m) {
  std::string out = paragraph(
      "The quadtree tests an area that may fail to enclose the projected one, so it can drop voxels that are seen. "
      "Enlarging the projected area by ε pixels on every side reduces that; the paper leaves the choice of ε open. "
      "Here every ε of the suite is tried on every view.");
  out += artifactFigures(m) + histogramTable(m) + enoughTable(m);
  std::string tables;
  for (const ArtifactStudy& study : m.artifacts) tables += epsilonTable(m, study);
  out += "<details><summary>Every ε</summary>\n" + tables + "</details>\n";
  return out;
}

std::string conditions(const Measurements& m) {
  const Suite& s = m.suite;
  std::string out = "<dl>";
  const auto item = [&](std::string_view term, const std::string& text) {
    out += fmt::format("<dt>{}</dt><dd>{}</dd>\n", term, text);
  };
  item("Processor", fmt::format("{}, {} logical cores", escaped(m.machine.processor), m.machine.logical_cores));
  item("Memory", m.machine.memory_bytes > 0 ? formatBytes(m.machine.memory_bytes) : std::string("unknown"));
  item("System", escaped(m.machine.system));
  item("Compiler", escaped(m.machine.compiler));
  item("Kiln", escaped(m.machine.version));
  item("The paper’s machine", std::string(kPublishedMachine));
  item("Threads", s.threads == 0 ? std::string("all") : std::to_string(s.threads));
  const auto [least, most] = std::minmax_element(s.cases.begin(), s.cases.end(),
                                                 [](const auto& a, const auto& b) { return a.repeat < b.repeat; });
  const std::string times = least->repeat == most->repeat ? std::to_string(most->repeat)
                                                          : fmt::format("{} to {}", least->repeat, most->repeat);
  item("Views", fmt::format("{} over {:g}°, each drawn {} time{} by each method; the median counts", s.views,
                            s.turn_deg, times, most->repeat == 1 ? "" : "s"));
  item("Walk", s.tile_px == 0 ? std::string("one sequential walk over the whole image, as in the paper")
                              : fmt::format("tiles of {0}×{0} pixels", s.tile_px));
  item("Projected area", s.area == ProjectedArea::kSphere
                             ? std::string("box around the projected circumscribed sphere, as in the paper")
                             : std::string("box around the projected cube and the footprint"));
  item("Opacity threshold", fmt::format("{:g}", s.threshold));
  item("Samples",
       s.test_samples ? "left out where all of their pixels are closed" : "not asked about, as in the paper");
  item("Took", roughDurationText(m.seconds) + ", conversions included");
  return out + "</dl>\n";
}

std::string methodSection(const Measurements& m) {
  std::uint64_t reads = 0;
  for (const MeasuredRun& run : m.runs)
    for (const FrameMeasurement& f : run.frames) reads += f.frame.bricks_read;
  std::string out = paragraph(
      "A time is a frame’s wall time from the walk’s first node to the finished picture in memory, without loading "
      "bricks, writing files, or building the octree. Every brick is in memory before anything is timed, and the "
      "methods take turns view by view, each beginning once, so that whatever else the machine does meets them "
      "alike. Speed-ups are ratios of mean times, as in the paper.");
  if (reads > 0) {
    out += paragraph(fmt::format("The bricks did not all stay in memory: {} were read again while frames were timed. "
                                 "What that took is taken off.",
                                 counted(static_cast<double>(reads))),
                     "warning");
  }
  out += conditions(m);
  out += paragraph("To repeat it, with the suite below:") +
         fmt::format("<pre>{}</pre>\n<pre>{}</pre>\n", escaped(m.command), escaped(m.suite.text));
  return out;
}

std::string costSection(const Measurements& m) {
  return paragraph(
             "An update marks a pixel as opaque in a structure; a test finds whether all pixels of a rectangle are "
             "opaque. Complexities are worst cases; the measured costs are beside them.") +
         complexityTable(m) + costFigure(m);
}

}  // namespace

std::string measurementsHtml(const Measurements& m) {
  std::string body = head(m);
  body += section("standings", "Which method wins", standingsTable(m) + observationsTable(m));
  body += section("data", "Data", dataTable(m));
  body += section("visited", "Voxels visited", visitedSection(m));
  body += section("times", "Times", timesSection(m));
  if (hasMethod(m, VisibilityMethod::kOverlay)) {
    body += section("overlay", "Overlay",
                    paragraph("Meagher’s four enclosing squares, which the paper compares with its own two.") +
                        visitsTable(m, VisibilityMethod::kOverlay, "5(a)") +
                        timesTable(m, VisibilityMethod::kOverlay, "5(b)"));
  }
  if (!m.costs.updates.empty()) body += section("costs", "Tests and updates", costSection(m));
  if (!m.scaling.empty()) body += section("scaling", "Volumes of several sizes", scalingTable(m) + scalingFigure(m));
  if (!m.slices.empty()) body += section("nodes", "Nodes visited", nodeSliceFigures(m));
  std::string pictures;
  for (const Projection projection : m.suite.projections)
    pictures += picturesFigure(m, projection, projection == Projection::kOrthographic ? "Figure 9." : "Figure 10.");
  body += section("pictures", "Pictures", pictures);
  if (!m.artifacts.empty()) body += section("artifacts", "Artifacts of the approximate test", artifactsSection(m));
  body += section("method", "How it was measured", methodSection(m));
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\"/>\n<title>{}</title>\n<style>{}{}</style></head>\n"
      "<body><main>\n{}</main></body></html>\n",
      escaped(m.suite.title), kReportStyle, svgStyle(), body);
}

}  // namespace kiln
