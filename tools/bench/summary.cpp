#include "bench/summary.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kiln {
namespace {

MethodSummary meansOf(const MeasuredRun& run, VisibilityMethod method, std::size_t& count) {
  MethodSummary out;
  count = 0;
  for (const FrameMeasurement& f : run.frames) {
    if (f.method != method) continue;
    ++count;
    out.visited += static_cast<double>(f.frame.voxels_visited);
    out.splats += static_cast<double>(f.frame.voxels_splats);
    out.nodes_tested += static_cast<double>(f.frame.nodes_tested);
    out.nodes_hidden += static_cast<double>(f.frame.nodes_hidden);
    out.render_s += f.render_s;
    out.identical = out.identical && f.identical;
    out.distance.add(f.distance);
  }
  if (count == 0) return out;
  const auto n = static_cast<double>(count);
  for (double* mean : {&out.visited, &out.splats, &out.nodes_tested, &out.nodes_hidden, &out.render_s}) *mean /= n;
  return out;
}

}  // namespace

std::optional<MethodSummary> summaryOf(const MeasuredRun& run, VisibilityMethod method) {
  std::size_t count = 0, baseline_count = 0;
  MethodSummary out = meansOf(run, method, count);
  const MethodSummary baseline = meansOf(run, VisibilityMethod::kNone, baseline_count);
  if (count == 0 || baseline_count == 0) return std::nullopt;
  // A volume without visible voxels has no work to save.
  out.ratio_percent = baseline.visited > 0 ? 100 * out.visited / baseline.visited : 100;
  out.speed_up = out.render_s > 0 ? baseline.render_s / out.render_s : 1;
  return out;
}

const MeasuredRun* findRun(const Measurements& m, std::size_t case_index, const ImageSize& size,
                           Projection projection) {
  const auto found = std::find_if(m.runs.begin(), m.runs.end(), [&](const MeasuredRun& run) {
    return run.case_index == case_index && run.size.width == size.width && run.size.height == size.height &&
           run.projection == projection;
  });
  return found == m.runs.end() ? nullptr : &*found;
}

std::optional<MethodSummary> summaryIn(const Measurements& m, std::size_t case_index, const ImageSize& size,
                                       Projection projection, VisibilityMethod method) {
  const MeasuredRun* run = findRun(m, case_index, size, projection);
  return run != nullptr ? summaryOf(*run, method) : std::nullopt;
}

std::vector<Standing> standingsOf(const Measurements& m) {
  std::vector<Standing> out;
  for (const VisibilityMethod method : m.suite.methods) {
    Standing standing{method};
    standing.least_speed_up = std::numeric_limits<double>::infinity();
    standing.greatest_speed_up = 0;
    double log_speed_up = 0, log_ratio = 0, runs = 0;
    for (const MeasuredRun& run : m.runs) {
      const auto own = summaryOf(run, method);
      if (!own) continue;
      ++runs;
      log_speed_up += std::log(own->speed_up);
      log_ratio += std::log(std::max(own->ratio_percent, 1e-9));
      standing.least_speed_up = std::min(standing.least_speed_up, own->speed_up);
      standing.greatest_speed_up = std::max(standing.greatest_speed_up, own->speed_up);
      const bool wins = std::all_of(m.suite.methods.begin(), m.suite.methods.end(), [&](VisibilityMethod other) {
        return other == method || summaryOf(run, other)->render_s > own->render_s;
      });
      standing.wins += wins ? 1 : 0;
    }
    if (runs == 0) continue;
    standing.speed_up = std::exp(log_speed_up / runs);
    standing.ratio_percent = std::exp(log_ratio / runs);
    out.push_back(standing);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Standing& a, const Standing& b) { return a.speed_up > b.speed_up; });
  return out;
}

}  // namespace kiln
