// A suite of measurements: volumes, views and methods. The JSON is read as strictly as a job's: an unknown key is an
// error, a path is relative to the suite's folder. The defaults are the experiment of Lee and Ihm §3: a sequential walk
// over the whole image, the projected area of §2.2.3, a threshold of 0.95.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "job/render_job.h"

namespace kiln {

/// A slice through the octree for Figure 7. The default index is the middle of the volume.
struct NodeSliceRequest {
  int axis = 1;
  std::optional<std::int64_t> index;
};

struct SuiteCase {
  std::string name;            // "HEAD"
  std::string classification;  // "bone", shown in tables
  std::string volume;          // a store, a volume file, or phantom:NAME:XxYxZ
  std::string note;            // differences from the paper's data, shown in tables
  std::string paper;           // row of the paper's tables repeated by this case; may be empty
  TransferFunctionChoice transfer_function = std::string("auto");
  Shading shading;
  /// The middle view. `zoom` moves a perspective eye nearer, because the suite fixes the field of view.
  CameraSpec camera;
  std::vector<ImageSize> sizes = {{512, 512}};
  std::optional<NodeSliceRequest> node_slice;
  bool artifacts = false;  // compare the quadtree's pictures with the exact pictures (Figure 11)
  bool quick = true;       // include in a quick run
  int repeat = 3;          // draws per view and method; the median counts
};

/// Costs of tests and updates, measured on the visibility structures alone, without a volume. Empty lists skip the
/// measurement. unit: pixels along the edges of images and of the tested areas.
struct CostRequest {
  std::vector<int> sizes_px = {256, 512, 1024, 2048, 4096};
  std::vector<int> areas_px = {4, 8, 16, 32, 64, 128};
};

/// An object at several volume sizes, drawn with the defaults of `kiln render`: growth of a frame's time and memory
/// with the volume. No volumes skip the measurement.
struct ScalingRequest {
  std::vector<std::string> volumes;  // as the volume of a case
  ImageSize size{1024, 1024};
  TransferFunctionChoice transfer_function = std::string("auto");
  CameraSpec camera;
  int repeat = 5;  // draws after the first draw; their median counts
};

struct Suite {
  std::filesystem::path path;
  std::string text;  // the text of the file
  std::string title = "Measurements";
  std::vector<VisibilityMethod> methods = {VisibilityMethod::kNone, VisibilityMethod::kRangeTree,
                                           VisibilityMethod::kQuadtree, VisibilityMethod::kOverlay,
                                           VisibilityMethod::kMask};
  std::vector<Projection> projections = {Projection::kOrthographic, Projection::kPerspective};
  double fov_deg = 60;
  double threshold = 0.95;
  int views = 5;
  double turn_deg = 40;  // between the first view and the last, about the camera's up
  unsigned threads = 1;  // 0: all
  int tile_px = 0;       // 0: the whole image is one tile; else a power of two from 64 on
  ProjectedArea area = ProjectedArea::kSphere;
  bool test_samples = false;  // skip samples on closed pixels, too
  std::uint64_t memory_bytes = 4ull << 30;
  /// Enlargements of the quadtree's area tried by `artifacts`, ascending. unit: pixels.
  std::vector<int> epsilons_px = {0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64};
  CostRequest cost;
  ScalingRequest scaling;
  std::vector<SuiteCase> cases;
  bool quick = false;  // set by `quickened`
};

/// throws: Error kFormat if the text is not JSON, kUsage for an unknown key (naming the nearest known key), a missing
/// key or a wrong value; readSuite also kNotFound, kIo.
Suite parseSuite(const std::string& text, const std::filesystem::path& path);
Suite readSuite(const std::filesystem::path& path);

/// Returns a faster version of the suite: two views drawn once, the first size of each case, images up to 1024 pixels
/// for the costs, without the cases marked "quick": false. throws: Error kUsage if no case is left.
Suite quickened(Suite suite);

}  // namespace kiln
