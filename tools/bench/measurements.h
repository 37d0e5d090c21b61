// What a run of a suite leaves: every number that the reports show, and the pictures as the bytes of their files.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "bench/machine.h"
#include "bench/suite.h"
#include "bench/visibility_cost.h"
#include "frame/statistics.h"
#include "image/compare.h"
#include "store/manifest/manifest.h"
#include "traverse/node_log.h"

namespace kiln {

/// The volume of a case.
struct VolumeSummary {
  Extent3 dims;
  glm::dvec3 spacing{1};
  VoxelType type = VoxelType::u8;
  std::string format;  // of the source
  std::uint64_t bricks = 0, stored_bytes = 0;
  double convert_s = 0;  // 0 where the store was there
};

/// One method's draws of one view: a line of the CSV.
struct FrameMeasurement {
  VisibilityMethod method = VisibilityMethod::kNone;
  int view = 0;
  double turn_deg = 0;
  double render_s = 0;   // the median draw, loading taken off
  double fastest_s = 0;  // the least
  FrameStatistics frame;
  /// The picture against octree only: whether every bit is the same, and how far apart the two are on a display.
  bool identical = true;
  DistanceHistogram distance;
};

/// One case at one size in one projection.
struct MeasuredRun {
  std::size_t case_index = 0;
  ImageSize size;
  Projection projection = Projection::kOrthographic;
  std::vector<FrameMeasurement> frames;
};

struct Picture {
  std::size_t case_index = 0;
  ImageSize size;
  Projection projection = Projection::kOrthographic;
  std::vector<std::byte> png;
};

/// The quadtree with one enlargement of its area, over all views.
struct EpsilonStep {
  int epsilon_px = 0;
  DistanceHistogram distance;  // of all views together
  double visited = 0;          // mean
  double render_s = 0;         // mean of the views' medians
};

/// The quadtree's pictures against the exact ones (Figure 11).
struct ArtifactStudy {
  std::size_t case_index = 0;
  ImageSize size;
  Projection projection = Projection::kOrthographic;
  std::vector<EpsilonStep> steps;
  std::optional<std::size_t> enough;            // the first step at which no pixel is off by more than 1
  double exact_s = 0, exact_visited = 0;        // the range tree, interleaved with the steps
  double baseline_s = 0, baseline_visited = 0;  // octree only, the same
  int worst_view = 0;                           // with the largest distance at ε = 0: the one in the pictures
  std::vector<std::byte> exact_png, approximate_png, difference_png, difference_enough_png;
};

/// The nodes that one frame asked about, in a slice (Figure 7).
struct NodeSlice {
  std::size_t case_index = 0;
  Projection projection = Projection::kOrthographic;
  VisibilityMethod method = VisibilityMethod::kNone;
  std::uint64_t visited = 0;  // voxels of the whole frame
  glm::dvec3 forward{0};      // the direction of view along the volume's axes, in world lengths
  NodeLog log;
};

/// One size of the scaling study.
struct ScalingPoint {
  VolumeSummary volume;
  double first_s = 0;              // the frame from an empty cache, reading included
  double render_s = 0;             // the median frame after it
  std::uint64_t memory_bytes = 0;  // bricks at their most, image, visibility and index
  FrameStatistics first;           // of the frame from an empty cache
};

struct Measurements {
  Suite suite;
  Machine machine;
  std::string command, time;           // of the run; time in UTC
  double seconds = 0;                  // it took
  std::vector<VolumeSummary> volumes;  // one a case
  std::vector<MeasuredRun> runs;
  std::vector<Picture> pictures;
  std::vector<ArtifactStudy> artifacts;
  std::vector<NodeSlice> slices;
  VisibilityCosts costs;
  std::vector<ScalingPoint> scaling;  // as the suite has the volumes
};

inline bool hasMethod(const Measurements& m, VisibilityMethod method) {
  return std::find(m.suite.methods.begin(), m.suite.methods.end(), method) != m.suite.methods.end();
}

}  // namespace kiln
