#include "bench/run_suite.h"

#include <chrono>
#include <cstring>
#include <glm/geometric.hpp>

#include "base/thread/parallel.h"
#include "bench/artifacts.h"
#include "bench/case_drawing.h"
#include "bench/scaling.h"
#include "bench/suite_stores.h"
#include "image/file/png_file.h"

namespace kiln {
namespace {

using Clock = std::chrono::steady_clock;

bool sameBits(const Image& a, const Image& b) {
  return a.rgba.size() == b.rgba.size() &&
         std::memcmp(a.rgba.data(), b.rgba.data(), a.rgba.size() * sizeof(float)) == 0;
}

VolumeSummary summaryOfStore(const StoreReader& store, double convert_s) {
  const Manifest& manifest = store.manifest();
  VolumeSummary out;
  out.dims = manifest.geometry().dims;
  out.spacing = manifest.geometry().spacing();
  out.type = manifest.type;
  out.format = manifest.source.format;
  out.bricks = static_cast<std::uint64_t>(store.index().lattice(0).count());
  out.stored_bytes = manifest.levels.front().stored_bytes;
  out.convert_s = convert_s;
  return out;
}

class SuiteRun {
 public:
  SuiteRun(Measurements& out, Progress& progress,
           const std::function<void(const Measurements&, const MeasuredRun&)>& on_run)
      : suite_(out.suite), out_(out), progress_(progress), on_run_(on_run) {
    for (const SuiteCase& c : suite_.cases) views_total_ += c.sizes.size() * suite_.projections.size();
    views_total_ *= static_cast<std::uint64_t>(suite_.views);
  }

  void drawCase(std::size_t index, const std::filesystem::path& store, double convert_s) {
    const SuiteCase& c = suite_.cases[index];
    CaseDrawing drawing(suite_, c, store, progress_);
    out_.volumes.push_back(summaryOfStore(drawing.store(), convert_s));
    drawing.warmUp();
    for (const ImageSize& size : c.sizes) {
      for (const Projection projection : suite_.projections) {
        out_.runs.push_back({index, size, projection, {}});
        measure(out_.runs.back(), drawing);
        on_run_(out_, out_.runs.back());
      }
    }
    if (c.node_slice) slice(index, drawing);
    if (!c.artifacts) return;
    for (const Projection projection : suite_.projections)
      out_.artifacts.push_back(studyArtifacts(suite_, index, drawing, projection));
  }

 private:
  void measure(MeasuredRun& run, CaseDrawing& drawing) {
    const std::vector<SuiteView> views = drawing.views(run.size, run.projection);
    for (std::size_t v = 0; v < views.size(); ++v) {
      std::vector<MeasuredFrame> frames(suite_.methods.size());
      // Rotates the first method from view to view, so that no method always inherits another method's caches.
      for (std::size_t i = 0; i < frames.size(); ++i) {
        const std::size_t m = (i + v) % frames.size();
        frames[m] =
            drawing.draw(views[v].view, drawing.optionsFor(suite_.methods[m]), suite_.cases[run.case_index].repeat);
      }
      for (std::size_t m = 0; m < frames.size(); ++m) {
        FrameMeasurement measured;
        measured.method = suite_.methods[m];
        measured.view = static_cast<int>(v);
        measured.turn_deg = views[v].turn_deg;
        measured.render_s = frames[m].medianSeconds();
        measured.fastest_s = frames[m].leastSeconds();
        measured.frame = frames[m].statistics;
        measured.identical = sameBits(frames.front().image, frames[m].image);
        measured.distance = distanceHistogram(frames.front().image, frames[m].image);
        run.frames.push_back(measured);
      }
      if (v == middleView(suite_)) keepPicture(run, frames.front().image);
      progress_.advance("measuring", "views", ++views_done_, views_total_);
    }
  }

  // Keeps the largest image of each case and projection.
  void keepPicture(const MeasuredRun& run, const Image& image) {
    const std::vector<ImageSize>& sizes = suite_.cases[run.case_index].sizes;
    const auto pixels = [](const ImageSize& s) { return std::int64_t{s.width} * s.height; };
    for (const ImageSize& other : sizes)
      if (pixels(other) > pixels(run.size)) return;
    out_.pictures.push_back({run.case_index, run.size, run.projection, encodePng(image, 8, "picture")});
  }

  // Slices as in the paper: octree only once, then the quadtree, and then the mask, in each projection.
  void slice(std::size_t index, CaseDrawing& drawing) {
    for (const VisibilityMethod method : suite_.methods) {
      if (method == VisibilityMethod::kRangeTree || method == VisibilityMethod::kOverlay) continue;
      for (const Projection projection : suite_.projections) {
        if (method == VisibilityMethod::kNone && projection != suite_.projections.front()) continue;
        out_.slices.push_back(sliceOf(index, drawing, projection, method));
      }
    }
  }

  NodeSlice sliceOf(std::size_t index, CaseDrawing& drawing, Projection projection, VisibilityMethod method) {
    const SuiteCase& c = suite_.cases[index];
    const VolumeGeometry& volume = drawing.store().manifest().geometry();
    NodeSlice out;
    out.case_index = index;
    out.projection = projection;
    out.method = method;
    out.log.axis = c.node_slice->axis;
    out.log.plane = c.node_slice->index.value_or(volume.dims[out.log.axis] / 2);
    const View view = drawing.views(c.sizes.front(), projection)[middleView(suite_)].view;
    // Components along the volume's axes, each of unit length.
    for (int axis = 0; axis < 3; ++axis) {
      const glm::dvec3 edge(volume.world_from_index[axis]);
      out.forward[axis] = glm::dot(view.forward_world, edge) / glm::length(edge);
    }
    out.visited = drawing.draw(view, drawing.optionsFor(method), 1, &out.log).statistics.voxels_visited;
    return out;
  }

  const Suite& suite_;
  Measurements& out_;
  Progress& progress_;
  const std::function<void(const Measurements&, const MeasuredRun&)>& on_run_;
  std::uint64_t views_done_ = 0, views_total_ = 0;
};

}  // namespace

Measurements runSuite(const Suite& suite, const BenchOptions& options, Progress& progress,
                      const std::function<void(const Measurements&, const MeasuredRun&)>& on_run) {
  const auto begin = Clock::now();
  Measurements out;
  out.suite = suite;
  out.machine = thisMachine();
  out.command = options.command;
  out.time = options.time;
  // Converts everything first: a missing file is found before an hour is spent, and conversions use all threads.
  std::vector<SuiteStore> stores;
  for (const SuiteCase& c : suite.cases)
    stores.push_back(
        suiteStore(c.volume, SuiteLevels::kFinest, options.stores, options.command, options.time, progress));
  std::vector<SuiteStore> scaling;
  for (const std::string& volume : suite.scaling.volumes)
    scaling.push_back(suiteStore(volume, SuiteLevels::kAll, options.stores, options.command, options.time, progress));
  const ThreadLimit threads(suite.threads);
  out.costs = measureVisibilityCosts(suite.methods, suite.cost, progress);
  SuiteRun run(out, progress, on_run);
  for (std::size_t i = 0; i < suite.cases.size(); ++i) run.drawCase(i, stores[i].path, stores[i].convert_s);
  for (const SuiteStore& store : scaling) {
    out.scaling.push_back(measureScaling(suite, store.path, progress));
    out.scaling.back().volume = summaryOfStore(StoreReader(store.path), store.convert_s);
  }
  out.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return out;
}

}  // namespace kiln
