// Summarises frames for the tables: means over the views, ratios to octree only, and the ranking of methods.
#pragma once

#include <optional>
#include <vector>

#include "bench/measurements.h"

namespace kiln {

struct MethodSummary {
  double visited = 0;                                     // mean
  double ratio_percent = 0;                               // relative to octree only
  double render_s = 0;                                    // mean over the views of the median draw
  double speed_up = 1;                                    // octree only's mean time over this method's
  double splats = 0, nodes_tested = 0, nodes_hidden = 0;  // means
  bool identical = true;                                  // every picture equals octree only's, bit for bit
  DistanceHistogram distance;
};

/// Empty if the run has no such frames.
std::optional<MethodSummary> summaryOf(const MeasuredRun& run, VisibilityMethod method);

/// nullptr if there is no such run.
const MeasuredRun* findRun(const Measurements& m, std::size_t case_index, const ImageSize& size, Projection projection);

/// Summary of a method in one run of the suite; empty if there is no such run.
std::optional<MethodSummary> summaryIn(const Measurements& m, std::size_t case_index, const ImageSize& size,
                                       Projection projection, VisibilityMethod method);

/// Summary of a method over the whole suite.
struct Standing {
  VisibilityMethod method = VisibilityMethod::kNone;
  double speed_up = 1;       // geometric mean over the runs
  double ratio_percent = 0;  // geometric mean, of voxels visited
  std::size_t wins = 0;      // runs in which the method is the fastest
  double least_speed_up = 1, greatest_speed_up = 1;
};

/// Returns the methods of the suite, fastest first.
std::vector<Standing> standingsOf(const Measurements& m);

/// True for all methods except the quadtree: their pictures must equal octree only's, bit for bit.
inline bool isExact(VisibilityMethod method) { return method != VisibilityMethod::kQuadtree; }

}  // namespace kiln
