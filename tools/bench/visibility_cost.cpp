// Problem. Measure tests and updates in the access pattern of a frame, without a volume.
// Method. The octree's nodes are cells of 16×16 pixels, near cells first. Each cell is drawn as footprints of 4×4
// pixels two pixels apart; a pixel becomes opaque at the fourth footprint. Squares are tested in Morton order, because
// an octree walk jumps as rarely.
#include "bench/visibility_cost.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>

#include "frame/pass/make_visibility.h"

namespace kiln {
namespace {

constexpr int kCell_px = 16, kFootprint_px = 4, kStride_px = 2, kOpaqueAt = 4;
constexpr int kRuns = 3;
constexpr std::size_t kSquares = 4096;

struct Point {
  int x, y;
};

// Returns 64 well-mixed bits. Source: SplitMix64.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  /// Returns a number in [0, 1).
  double unit() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ z >> 27) * 0x94d049bb133111ebull;
    return static_cast<double>((z ^ z >> 31) >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

double discRadius(int size_px) { return 0.375 * size_px; }

// Returns the cells of the disc, near the middle first, slightly shuffled like the surface of an object.
std::vector<Point> cellsOf(int size_px) {
  struct Cell {
    Point at;
    double when;
  };
  Random random(1);
  std::vector<Cell> cells;
  const double middle = 0.5 * size_px;
  for (int y = 0; y + kCell_px <= size_px; y += kCell_px) {
    for (int x = 0; x + kCell_px <= size_px; x += kCell_px) {
      const double distance = std::hypot(x + kCell_px / 2 - middle, y + kCell_px / 2 - middle);
      if (distance <= discRadius(size_px)) cells.push_back({{x, y}, distance + 4 * kCell_px * random.unit()});
    }
  }
  std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) { return a.when < b.when; });
  std::vector<Point> out;
  for (const Cell& cell : cells) out.push_back(cell.at);
  return out;
}

// Draws the disc into `visibility`; returns the number of closed pixels.
std::uint64_t fill(Visibility& visibility, const std::vector<Point>& cells, int size_px,
                   std::vector<std::uint8_t>& touched) {
  std::fill(touched.begin(), touched.end(), std::uint8_t{0});
  std::uint64_t closed = 0;
  for (const Point& cell : cells) {
    for (int v = cell.y; v < cell.y + kCell_px; v += kStride_px) {
      for (int u = cell.x; u < cell.x + kCell_px; u += kStride_px) {
        for (int y = v; y < std::min(v + kFootprint_px, size_px); ++y) {
          for (int x = u; x < std::min(u + kFootprint_px, size_px); ++x) {
            if (++touched[static_cast<std::size_t>(y) * static_cast<std::size_t>(size_px) +
                          static_cast<std::size_t>(x)] != kOpaqueAt)
              continue;
            visibility.close(x, y);
            ++closed;
          }
        }
      }
    }
  }
  return closed;
}

std::uint64_t mortonOf(const PixelRect& rect) {
  std::uint64_t out = 0;
  for (int bit = 0; bit < 16; ++bit) {
    out |= static_cast<std::uint64_t>(rect.x0 >> bit & 1) << (2 * bit);
    out |= static_cast<std::uint64_t>(rect.y0 >> bit & 1) << (2 * bit + 1);
  }
  return out;
}

// Returns squares of `area_px` whose middle is at most `reach_px` from the image's middle, in Morton order.
std::vector<PixelRect> squares(int size_px, int area_px, double reach_px, bool round) {
  Random random(2);
  std::vector<PixelRect> out;
  while (out.size() < kSquares) {
    const double dx = (2 * random.unit() - 1) * reach_px, dy = (2 * random.unit() - 1) * reach_px;
    if (round && dx * dx + dy * dy > reach_px * reach_px) continue;
    const int x0 = static_cast<int>(0.5 * size_px + dx - 0.5 * area_px);
    const int y0 = static_cast<int>(0.5 * size_px + dy - 0.5 * area_px);
    if (x0 < 0 || y0 < 0 || x0 + area_px > size_px || y0 + area_px > size_px) continue;
    out.push_back({x0, y0, x0 + area_px, y0 + area_px});
  }
  std::sort(out.begin(), out.end(), [](const PixelRect& a, const PixelRect& b) { return mortonOf(a) < mortonOf(b); });
  return out;
}

double leastSeconds(const std::function<void()>& work) {
  double least = std::numeric_limits<double>::infinity();
  for (int run = 0; run < kRuns; ++run) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  return least;
}

// Sums the results into `answers`, so that the compiler cannot remove the tests.
double nsPerTest(const Visibility& visibility, const std::vector<PixelRect>& asked, std::uint64_t& answers) {
  constexpr int kRounds = 8;
  const double seconds = leastSeconds([&] {
    for (int round = 0; round < kRounds; ++round)
      for (const PixelRect& rect : asked) answers += visibility.hidden(rect) ? 1 : 0;
  });
  return 1e9 * seconds / static_cast<double>(asked.size() * kRounds);
}

std::unique_ptr<Visibility> make(VisibilityMethod method, int size_px) {
  VisibilityOptions options;
  options.method = method;
  return makeVisibility(options, {size_px, size_px}, 0);
}

class Measurement {
 public:
  Measurement(const std::vector<VisibilityMethod>& methods, const CostRequest& request, Progress& progress)
      : request_(request), progress_(progress) {
    for (const VisibilityMethod method : methods)
      if (method != VisibilityMethod::kNone) methods_.push_back(method);
  }

  VisibilityCosts run() {
    std::uint64_t done = 0;
    for (const int size_px : request_.sizes_px) {
      const std::vector<Point> cells = cellsOf(size_px);
      std::vector<std::uint8_t> touched(static_cast<std::size_t>(size_px) * static_cast<std::size_t>(size_px));
      const std::unique_ptr<Visibility> nothing = make(VisibilityMethod::kNone, size_px);
      const double loop_s = leastSeconds([&] { fill(*nothing, cells, size_px, touched); });
      for (const VisibilityMethod method : methods_) {
        progress_.throwIfCancelled("measuring tests and updates");
        measure(method, size_px, cells, touched, loop_s);
        progress_.advance("measuring tests and updates", "structures", ++done,
                          request_.sizes_px.size() * methods_.size());
      }
    }
    return std::move(costs_);
  }

 private:
  void measure(VisibilityMethod method, int size_px, const std::vector<Point>& cells,
               std::vector<std::uint8_t>& touched, double loop_s) {
    std::unique_ptr<Visibility> filled;
    std::uint64_t pixels = 0;
    double seconds = std::numeric_limits<double>::infinity();
    for (int run = 0; run < kRuns; ++run) {
      filled = make(method, size_px);  // construction is paid once per frame and not counted
      const auto begin = std::chrono::steady_clock::now();
      pixels = fill(*filled, cells, size_px, touched);
      seconds = std::min(seconds, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
    const double update_s = std::max(0.0, seconds - loop_s);
    costs_.updates.push_back({method, size_px, pixels, pixels > 0 ? 1e9 * update_s / static_cast<double>(pixels) : 0});
    for (const int area_px : request_.areas_px) {
      if (2 * area_px > size_px) continue;
      // Radius of the disc, reduced so that squares around inner points lie entirely inside.
      const double reach_px = discRadius(size_px) - 2 * kCell_px - area_px / std::sqrt(2.0);
      TestCost test{method, size_px, area_px, 0, 0};
      if (reach_px >= kCell_px)
        test.hidden_ns = nsPerTest(*filled, squares(size_px, area_px, reach_px, true), answers_);
      test.mixed_ns = nsPerTest(*filled, squares(size_px, area_px, 0.5 * size_px, false), answers_);
      costs_.tests.push_back(test);
    }
  }

  CostRequest request_;
  Progress& progress_;
  std::vector<VisibilityMethod> methods_;
  VisibilityCosts costs_;
  std::uint64_t answers_ = 0;
};

}  // namespace

VisibilityCosts measureVisibilityCosts(const std::vector<VisibilityMethod>& methods, const CostRequest& request,
                                       Progress& progress) {
  return Measurement(methods, request, progress).run();
}

}  // namespace kiln
