#include "bench/artifacts.h"

#include "image/file/png_file.h"

namespace kiln {
namespace {

// Exact pictures fit in memory: the paper's are 256×256.
class Study {
 public:
  Study(const Suite& suite, CaseDrawing& drawing, int repeat) : suite_(suite), drawing_(drawing), repeat_(repeat) {}

  void run(ArtifactStudy& out) {
    const std::vector<SuiteView> views = drawing_.views(out.size, out.projection);
    for (const int epsilon_px : suite_.epsilons_px) out.steps.emplace_back().epsilon_px = epsilon_px;
    double worst = -1;
    for (std::size_t v = 0; v < views.size(); ++v) {
      const MeasuredFrame baseline = draw(views[v].view, VisibilityMethod::kNone, 0);
      const MeasuredFrame exact = draw(views[v].view, VisibilityMethod::kRangeTree, 0);
      add(baseline, out.baseline_s, out.baseline_visited);
      add(exact, out.exact_s, out.exact_visited);
      for (EpsilonStep& step : out.steps) {
        const MeasuredFrame approximate = draw(views[v].view, VisibilityMethod::kQuadtree, step.epsilon_px);
        const DistanceHistogram distance = distanceHistogram(exact.image, approximate.image);
        step.distance.add(distance);
        add(approximate, step.render_s, step.visited);
        if (&step != &out.steps.front() || distance.largest <= worst) continue;
        worst = distance.largest;
        out.worst_view = static_cast<int>(v);
      }
    }
    for (std::size_t i = 0; i < out.steps.size() && !out.enough; ++i)
      if (out.steps[i].distance.largest <= 1) out.enough = i;
    drawPictures(out, views[static_cast<std::size_t>(out.worst_view)].view);
  }

 private:
  MeasuredFrame draw(const View& view, VisibilityMethod method, int epsilon_px) {
    return drawing_.draw(view, drawing_.optionsFor(method, epsilon_px), repeat_);
  }

  void add(const MeasuredFrame& frame, double& mean_s, double& mean_visited) const {
    mean_s += frame.medianSeconds() / suite_.views;
    mean_visited += static_cast<double>(frame.statistics.voxels_visited) / suite_.views;
  }

  void drawPictures(ArtifactStudy& out, const View& view) {
    const Image exact = draw(view, VisibilityMethod::kRangeTree, 0).image;
    const Image approximate = draw(view, VisibilityMethod::kQuadtree, 0).image;
    out.exact_png = encodePng(exact, 8, "exact");
    out.approximate_png = encodePng(approximate, 8, "quadtree");
    out.difference_png = encodePng(differenceImage(exact, approximate), 8, "difference");
    if (!out.enough || *out.enough == 0) return;
    const Image enlarged = draw(view, VisibilityMethod::kQuadtree, out.steps[*out.enough].epsilon_px).image;
    out.difference_enough_png = encodePng(differenceImage(exact, enlarged), 8, "difference");
  }

  const Suite& suite_;
  CaseDrawing& drawing_;
  int repeat_;
};

}  // namespace

ArtifactStudy studyArtifacts(const Suite& suite, std::size_t case_index, CaseDrawing& drawing, Projection projection) {
  ArtifactStudy out;
  out.case_index = case_index;
  out.size = suite.cases[case_index].sizes.front();
  out.projection = projection;
  Study(suite, drawing, suite.cases[case_index].repeat).run(out);
  return out;
}

}  // namespace kiln
