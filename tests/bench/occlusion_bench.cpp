// Cost of image-space coherence: time of a query and of a closed pixel, for each method, against the edge n of the
// image and the edge l of the queried rectangle. The image is filled as by a frame: discs of pixels close one after
// another. Queries fall everywhere, more than half of them on opaque pixels. Source of the complexities for comparison:
// Lee and Ihm, Table 4.
#include <benchmark/benchmark.h>

#include <random>
#include <utility>
#include <vector>

#include "frame/pass/make_visibility.h"

namespace kiln {
namespace {

std::unique_ptr<Visibility> make(std::int64_t method, int n) {
  VisibilityOptions options;
  options.method = static_cast<VisibilityMethod>(method);
  return makeVisibility(options, {n, n}, 0);
}

// Returns pixels in closing order: footprint by footprint along 24 discs that cover about two thirds.
std::vector<std::pair<int, int>> closingOrder(int n) {
  std::mt19937 random(7);
  std::vector<bool> closed(static_cast<std::size_t>(n) * n);
  std::vector<std::pair<int, int>> order;
  const auto upTo = [&](int m) { return static_cast<int>(random() % static_cast<unsigned>(m)); };
  for (int disc = 0; disc < 24; ++disc) {
    const int cx = upTo(n), cy = upTo(n), radius = n / 16 + upTo(n / 6);
    for (int by = cy - radius; by < cy + radius; by += 4) {
      for (int bx = cx - radius; bx < cx + radius; bx += 4) {
        for (int i = 0; i < 16; ++i) {
          const int x = bx + i % 4, y = by + i / 4;
          const int dx = x - cx, dy = y - cy;
          if (x < 0 || y < 0 || x >= n || y >= n || dx * dx + dy * dy >= radius * radius) continue;
          if (closed[static_cast<std::size_t>(y) * n + x]) continue;
          closed[static_cast<std::size_t>(y) * n + x] = true;
          order.emplace_back(x, y);
        }
      }
    }
  }
  return order;
}

// Arguments: method, n, l.
void test(benchmark::State& state) {
  const int n = static_cast<int>(state.range(1)), l = static_cast<int>(state.range(2));
  const auto visibility = make(state.range(0), n);
  for (const auto& [x, y] : closingOrder(n)) visibility->close(x, y);
  std::mt19937 random(11);
  std::vector<PixelRect> questions;
  for (int i = 0; i < 1 << 14; ++i) {
    const int x = static_cast<int>(random() % static_cast<unsigned>(n - l + 1));
    const int y = static_cast<int>(random() % static_cast<unsigned>(n - l + 1));
    questions.push_back({x, y, x + l, y + l});
  }
  std::size_t next = 0;
  std::int64_t hidden = 0;
  for (auto _ : state) hidden += visibility->hidden(questions[next++ & (questions.size() - 1)]) ? 1 : 0;
  state.counters["hidden"] = static_cast<double>(hidden) / static_cast<double>(state.iterations());
}

// Arguments: method, n. The reported time is per pixel.
void update(benchmark::State& state) {
  const int n = static_cast<int>(state.range(1));
  const auto order = closingOrder(n);
  std::unique_ptr<Visibility> visibility;
  std::size_t next = order.size();
  for (auto _ : state) {
    if (next == order.size()) {
      state.PauseTiming();
      visibility = make(state.range(0), n);
      next = 0;
      state.ResumeTiming();
    }
    visibility->close(order[next].first, order[next].second);
    ++next;
  }
}

const std::vector<std::int64_t> kMethods = {0, 1, 2, 3, 4};  // values of VisibilityMethod
const std::vector<std::int64_t> kSizes = {256, 512, 1024, 2048, 4096};
BENCHMARK(test)->ArgNames({"method", "n", "l"})->ArgsProduct({kMethods, kSizes, {4, 16, 64, 256}});
BENCHMARK(update)->ArgNames({"method", "n"})->ArgsProduct({kMethods, kSizes});

}  // namespace
}  // namespace kiln

BENCHMARK_MAIN();
