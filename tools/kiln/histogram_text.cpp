#include "histogram_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/number_text.h"

namespace kiln::tool {
namespace {

constexpr std::size_t kRows = 16;
constexpr double kBar = 32;  // characters of the longest

struct Row {
  double lo, hi;
  std::uint64_t count;
};

std::vector<Row> rowsOf(const ValueHistogram& h) {
  if (!(h.hi > h.lo)) return {{h.lo, h.hi, std::accumulate(h.counts.begin(), h.counts.end(), std::uint64_t{0})}};
  const std::size_t bins = h.counts.size(), rows = std::min(kRows, bins);
  const auto edge = [&](std::size_t bin) {
    return h.lo + (h.hi - h.lo) * static_cast<double>(bin) / static_cast<double>(bins);
  };
  std::vector<Row> out;
  for (std::size_t row = 0; row < rows; ++row) {
    const std::size_t first = row * bins / rows, end = (row + 1) * bins / rows;
    const auto counts = std::span(h.counts).subspan(first, end - first);
    out.push_back({edge(first), edge(end), std::accumulate(counts.begin(), counts.end(), std::uint64_t{0})});
  }
  return out;
}

}  // namespace

std::string histogramText(const ValueHistogram& histogram, bool whole, const std::string& indent) {
  const std::vector<Row> rows = rowsOf(histogram);
  std::uint64_t all = 0, largest = 0;
  for (const Row& row : rows) {
    all += row.count;
    largest = std::max(largest, row.count);
  }
  if (all == 0) return {};
  const double step = rows.front().hi - rows.front().lo;
  const auto label = [&](double value) { return whole ? fmt::format("{:.0f}", value) : numberText(value, step); };
  std::size_t width = 0;
  for (const Row& row : rows) width = std::max({width, label(row.lo).size(), label(row.hi).size()});
  std::string out;
  for (const Row& row : rows) {
    const double length = row.count == 0 ? 0
                                         : 1 + (kBar - 1) * std::log(static_cast<double>(row.count)) /
                                                   std::max(std::log(static_cast<double>(largest)), 1.0);
    out +=
        fmt::format("{}{:>{}} to {:>{}}  {:<{}} {:>8.4f} %  {} voxels\n", indent, label(row.lo), width, label(row.hi),
                    width, std::string(static_cast<std::size_t>(std::lround(length)), '#'), static_cast<int>(kBar),
                    100.0 * static_cast<double>(row.count) / static_cast<double>(all), row.count);
  }
  return out;
}

}  // namespace kiln::tool
