#include "bench/case_drawing.h"

#include <algorithm>

#include "sequence/render_job_run.h"

namespace kiln {
namespace {

TransferFunction functionOf(const SuiteCase& c, const StoreReader& store) {
  PictureOptions picture;
  picture.transfer_function = c.transfer_function;
  return transferFunctionFor(picture, store);
}

}  // namespace

double MeasuredFrame::medianSeconds() const {
  std::vector<double> sorted = render_s;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t middle = sorted.size() / 2;
  return sorted.size() % 2 == 1 ? sorted[middle] : 0.5 * (sorted[middle - 1] + sorted[middle]);
}

double MeasuredFrame::leastSeconds() const { return *std::min_element(render_s.begin(), render_s.end()); }

CaseDrawing::CaseDrawing(const Suite& suite, const SuiteCase& c, const std::filesystem::path& store, Progress& progress)
    : suite_(suite),
      case_(c),
      store_(store),
      cache_(store_, suite.memory_bytes),
      transfer_function_(functionOf(c, store_)),
      progress_(progress) {}

std::vector<SuiteView> CaseDrawing::views(const ImageSize& size, Projection projection) const {
  return suiteViews(suite_, case_, store_.manifest().geometry(), size, projection);
}

VisibilityOptions CaseDrawing::optionsFor(VisibilityMethod method, int epsilon_px) const {
  VisibilityOptions out;
  out.method = method;
  out.epsilon_px = epsilon_px;
  out.area = suite_.area;
  out.test_samples = suite_.test_samples;
  return out;
}

MeasuredFrame CaseDrawing::draw(const View& view, const VisibilityOptions& visibility, int repeat, NodeLog* log) {
  FrameRequest request;
  request.view = view;
  request.transfer_function = transfer_function_;
  request.shading = case_.shading;
  request.opacity_threshold = suite_.threshold;
  request.lattice = Lattice::kVoxel;  // Lee and Ihm's algorithm: the octree of level 0, each voxel once
  request.level = 0;
  request.visibility = visibility;
  request.tile_px = suite_.tile_px;
  request.node_log = log;
  MeasuredFrame out;
  for (int i = 0; i < repeat; ++i) {
    out.image = renderFrame(cache_, request, progress_, out.statistics);
    out.render_s.push_back(out.statistics.wall_s - out.statistics.load_s);
  }
  return out;
}

void CaseDrawing::warmUp() {
  // Octree only visits everything in the image, and the views differ little.
  const std::vector<SuiteView> small = views({64, 64}, suite_.projections.front());
  draw(small[middleView(suite_)].view, optionsFor(VisibilityMethod::kNone), 1);
}

}  // namespace kiln
