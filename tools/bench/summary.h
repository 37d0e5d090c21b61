// From frames to what a table shows: means over the views, ratios to octree only, and which method wins.
#pragma once

#include <optional>
#include <vector>

#include "bench/measurements.h"

namespace kiln {

struct MethodSummary {
  double visited = 0;                                     // mean
  double ratio_percent = 0;                               // of octree only's
  double render_s = 0;                                    // mean over the views of each view's median draw
  double speed_up = 1;                                    // octree only's mean time over this
  double splats = 0, nodes_tested = 0, nodes_hidden = 0;  // means
  bool identical = true;                                  // every picture bit for bit that of octree only
  DistanceHistogram distance;
};

/// Empty where the run has no such frames.
std::optional<MethodSummary> summaryOf(const MeasuredRun& run, VisibilityMethod method);

/// nullptr where there is no such run.
const MeasuredRun* findRun(const Measurements& m, std::size_t case_index, const ImageSize& size, Projection projection);

/// A method in one run of the suite; empty where there is none.
std::optional<MethodSummary> summaryIn(const Measurements& m, std::size_t case_index, const ImageSize& size,
                                       Projection projection, VisibilityMethod method);

/// A method over the whole suite.
struct Standing {
  VisibilityMethod method = VisibilityMethod::kNone;
  double speed_up = 1;       // geometric mean over the runs
  double ratio_percent = 0;  // the same, of voxels visited
  std::size_t wins = 0;      // runs in which it is the fastest of all
  double least_speed_up = 1, greatest_speed_up = 1;
};

/// The methods of the suite, fastest first.
std::vector<Standing> standingsOf(const Measurements& m);

/// Every method but the quadtree: its pictures are to be those of octree only, bit for bit.
inline bool isExact(VisibilityMethod method) { return method != VisibilityMethod::kQuadtree; }

}  // namespace kiln
