// The results of a suite: every number shown in the reports, and the pictures as file contents.
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
  std::string format;  // format of the source
  std::uint64_t bricks = 0, stored_bytes = 0;
  double convert_s = 0;  // 0 if the store existed
};

/// One method's draws of a view: a line of the CSV.
struct FrameMeasurement {
  VisibilityMethod method = VisibilityMethod::kNone;
  int view = 0;
  double turn_deg = 0;
  double render_s = 0;   // median draw, without loading
  double fastest_s = 0;  // fastest draw
  FrameStatistics frame;
  /// Compares the picture with octree only: equal in every bit, and the difference on a display.
  bool identical = true;
  DistanceHistogram distance;
};

/// A case at one size in one projection.
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

/// Results of the quadtree with one enlargement of the tested area, over all views.
struct EpsilonStep {
  int epsilon_px = 0;
  DistanceHistogram distance;  // over all views
  double visited = 0;          // mean
  double render_s = 0;         // mean of the views' medians
};

/// Compares the quadtree's pictures with the exact pictures (Figure 11).
struct ArtifactStudy {
  std::size_t case_index = 0;
  ImageSize size;
  Projection projection = Projection::kOrthographic;
  std::vector<EpsilonStep> steps;
  std::optional<std::size_t> enough;            // the first step with every pixel within 1
  double exact_s = 0, exact_visited = 0;        // the range tree, interleaved with the steps
  double baseline_s = 0, baseline_visited = 0;  // octree only, interleaved with the steps
  int worst_view = 0;                           // view with the largest distance at ε = 0, shown in the pictures
  std::vector<std::byte> exact_png, approximate_png, difference_png, difference_enough_png;
};

/// The nodes tested by a frame, in a slice (Figure 7).
struct NodeSlice {
  std::size_t case_index = 0;
  Projection projection = Projection::kOrthographic;
  VisibilityMethod method = VisibilityMethod::kNone;
  std::uint64_t visited = 0;  // voxels of the whole frame
  glm::dvec3 forward{0};      // view direction along the volume's axes, in world lengths
  NodeLog log;
};

/// One size of the scaling study.
struct ScalingPoint {
  VolumeSummary volume;
  double first_s = 0;              // frame from an empty cache, reading included
  double render_s = 0;             // median of the later frames
  std::uint64_t memory_bytes = 0;  // peak of the bricks, plus image, visibility and index
  FrameStatistics first;           // statistics of the first frame
};

struct Measurements {
  Suite suite;
  Machine machine;
  std::string command, time;           // command line, and time in UTC
  double seconds = 0;                  // duration of the run
  std::vector<VolumeSummary> volumes;  // one per case
  std::vector<MeasuredRun> runs;
  std::vector<Picture> pictures;
  std::vector<ArtifactStudy> artifacts;
  std::vector<NodeSlice> slices;
  VisibilityCosts costs;
  std::vector<ScalingPoint> scaling;  // in the order of the suite's volumes
};

inline bool hasMethod(const Measurements& m, VisibilityMethod method) {
  return std::find(m.suite.methods.begin(), m.suite.methods.end(), method) != m.suite.methods.end();
}

}  // namespace kiln
