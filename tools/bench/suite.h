// A suite of measurements: which volumes, seen how, drawn by which methods. Its JSON is read as strictly as a job's: an
// unknown key is an error, a path is relative to the suite's folder. What it asks by default is the experiment of Lee
// and Ihm §3: one sequential walk over the whole image, the projected area of §2.2.3, a threshold of 0.95.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "job/render_job.h"

namespace kiln {

/// A slice through the octree for Figure 7. The middle of the volume where no index is given.
struct NodeSliceRequest {
  int axis = 1;
  std::optional<std::int64_t> index;
};

struct SuiteCase {
  std::string name;            // "HEAD"
  std::string classification;  // "bone": for people
  std::string volume;          // a store, a volume file, or phantom:NAME:XxYxZ
  std::string note;            // how the data differ from the paper's: for people
  std::string paper;           // the row of the paper's tables that this case repeats; empty for none
  TransferFunctionChoice transfer_function = std::string("auto");
  Shading shading;
  /// The middle view. `zoom` moves a perspective eye nearer and leaves the field of view, which the suite fixes.
  CameraSpec camera;
  std::vector<ImageSize> sizes = {{512, 512}};
  std::optional<NodeSliceRequest> node_slice;
  bool artifacts = false;  // compare the quadtree's pictures with the exact ones (Figure 11)
  bool quick = true;       // drawn in a quick run, too
  int repeat = 3;          // draws of each view by each method; the median counts
};

/// The structures alone, without a volume: what a test and an update cost. unit: pixels along the edges of images and
/// of the areas asked about. Empty lists leave the measurement out.
struct CostRequest {
  std::vector<int> sizes_px = {256, 512, 1024, 2048, 4096};
  std::vector<int> areas_px = {4, 8, 16, 32, 64, 128};
};

/// One object at several sizes, drawn as `kiln render` does by default: how a frame's time and memory grow with the
/// volume. No volumes leave the measurement out.
struct ScalingRequest {
  std::vector<std::string> volumes;  // as a case's
  ImageSize size{1024, 1024};
  TransferFunctionChoice transfer_function = std::string("auto");
  CameraSpec camera;
  int repeat = 5;  // draws after the first; their median counts
};

struct Suite {
  std::filesystem::path path;
  std::string text;  // as it was read
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
  bool test_samples = false;  // whether samples on closed pixels are left out, too
  std::uint64_t memory_bytes = 4ull << 30;
  /// Enlargements of the quadtree's area that `artifacts` tries, ascending. unit: pixels.
  std::vector<int> epsilons_px = {0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64};
  CostRequest cost;
  ScalingRequest scaling;
  std::vector<SuiteCase> cases;
  bool quick = false;  // what `quickened` made it
};

/// throws: Error kFormat where the text is not JSON, kUsage for an unknown key (naming the nearest known one), a
/// missing one or a wrong value; readSuite also kNotFound, kIo.
Suite parseSuite(const std::string& text, const std::filesystem::path& path);
Suite readSuite(const std::filesystem::path& path);

/// The same questions asked faster: two views drawn once, each case's first size, images up to 1024 pixels for the
/// costs, and without the cases that say so. throws: Error kUsage where no case is left.
Suite quickened(Suite suite);

}  // namespace kiln
