#include "bench/observations.h"

#include "bench/published.h"
#include "bench/summary.h"

namespace kiln {
namespace {

// A number as printed in the paper and as measured by the suite.
struct Both {
  double paper, here;
};

class Observer {
 public:
  explicit Observer(const Measurements& m) : m_(m) {}

  std::vector<Observation> all() const {
    std::vector<Observation> out = {compareMethods("The quadtree is faster than the range tree",
                                                   VisibilityMethod::kQuadtree, VisibilityMethod::kRangeTree),
                                    compareMethods("The range tree is faster than the overlay",
                                                   VisibilityMethod::kRangeTree, VisibilityMethod::kOverlay),
                                    compareProjections(), compareSizes()};
    std::erase_if(out, [](const Observation& o) { return o.comparisons == 0; });
    return out;
  }

 private:
  std::optional<Both> speedUp(const MeasuredRun& run, VisibilityMethod method) const {
    const auto paper = publishedTimes(m_.suite.cases[run.case_index].paper, run.size, run.projection, method);
    const auto here = summaryOf(run, method);
    return paper && here ? std::optional(Both{paper->speed_up, here->speed_up}) : std::nullopt;
  }

  // Counts a comparison, and whether the first method gains more.
  static void count(Observation& o, const std::optional<Both>& more, const std::optional<Both>& less) {
    if (!more || !less) return;
    ++o.comparisons;
    o.in_paper += more->paper > less->paper ? 1 : 0;
    o.here += more->here > less->here ? 1 : 0;
  }

  Observation compareMethods(const char* sentence, VisibilityMethod faster, VisibilityMethod slower) const {
    Observation out{sentence};
    for (const MeasuredRun& run : m_.runs) count(out, speedUp(run, faster), speedUp(run, slower));
    return out;
  }

  Observation compareProjections() const {
    Observation out{"The range tree gains more in perspective than in orthographic projection"};
    for (const MeasuredRun& run : m_.runs) {
      if (run.projection != Projection::kPerspective) continue;
      const MeasuredRun* other = findRun(m_, run.case_index, run.size, Projection::kOrthographic);
      if (other) count(out, speedUp(run, VisibilityMethod::kRangeTree), speedUp(*other, VisibilityMethod::kRangeTree));
    }
    return out;
  }

  Observation compareSizes() const {
    Observation out{"The range tree gains less in a larger image of the same volume"};
    for (const MeasuredRun& run : m_.runs) {
      for (const MeasuredRun& larger : m_.runs) {
        const bool same = larger.case_index == run.case_index && larger.projection == run.projection;
        if (same && larger.size.width > run.size.width)
          count(out, speedUp(run, VisibilityMethod::kRangeTree), speedUp(larger, VisibilityMethod::kRangeTree));
      }
    }
    return out;
  }

  const Measurements& m_;
};

}  // namespace

std::vector<Observation> observationsOf(const Measurements& m) { return Observer(m).all(); }

}  // namespace kiln
