#include "bench/report/report_text.h"

#include <fmt/format.h>

#include "bench/published.h"
#include "bench/summary.h"
#include "job/job_names.h"

namespace kiln {

std::string runText(const Measurements& m, const MeasuredRun& run) {
  const SuiteCase& c = m.suite.cases[run.case_index];
  std::string out =
      fmt::format("{} {}x{} {}\n", c.name, run.size.width, run.size.height, nameIn(kProjectionNames, run.projection));
  for (const VisibilityMethod method : m.suite.methods) {
    const auto s = summaryOf(run, method);
    if (!s) continue;
    out += fmt::format("  {:<10} {:>12.0f} voxels {:6.2f} %  {:>9.2f} ms {:6.2f} x", nameIn(kVisibilityNames, method),
                       s->visited, s->ratio_percent, 1e3 * s->render_s, s->speed_up);
    const auto visits = publishedVisits(c.paper, run.size, run.projection, method);
    const auto times = publishedTimes(c.paper, run.size, run.projection, method);
    if (visits && times) {
      out += fmt::format("   (paper: {} voxels {:.2f} %, {:.2f} s {:.2f} x)", visits->visited, visits->ratio_percent,
                         times->method_s, times->speed_up);
    }
    if (isExact(method) && !s->identical) out += "   NOT the picture of octree only";
    out += "\n";
  }
  return out;
}

std::string standingsText(const Measurements& m) {
  std::string out;
  for (const Standing& s : standingsOf(m)) {
    out += fmt::format("{:<10} {:6.2f} x over octree only ({:.2f} to {:.2f}), fastest in {} of {} runs\n",
                       nameIn(kVisibilityNames, s.method), s.speed_up, s.least_speed_up, s.greatest_speed_up, s.wins,
                       m.runs.size());
  }
  return out;
}

}  // namespace kiln
