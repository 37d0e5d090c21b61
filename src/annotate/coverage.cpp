#include "annotate/coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace kiln {
namespace {

// Farther places are outside of every picture.
constexpr double kFarthest_px = 1 << 20;

void addInterval(std::int64_t begin, std::int64_t end, int first_column, std::span<std::int32_t> sums) {
  const std::int64_t origin = std::int64_t{first_column} * Coverage::kSteps;
  const auto limit = static_cast<std::int64_t>(sums.size()) * Coverage::kSteps;
  begin = std::max<std::int64_t>(begin - origin, 0);
  end = std::min(end - origin, limit);
  while (begin < end) {
    const std::int64_t column = begin / Coverage::kSteps;
    const std::int64_t next = std::min((column + 1) * Coverage::kSteps, end);
    sums[static_cast<std::size_t>(column)] += static_cast<std::int32_t>(next - begin);
    begin = next;
  }
}

}  // namespace

Coverage::Coverage(const Outline& outline) {
  double top = std::numeric_limits<double>::infinity(), bottom = -top;
  const auto near = [](const glm::dvec2& p) {
    return glm::dvec2(std::clamp(p.x, -kFarthest_px, kFarthest_px), std::clamp(p.y, -kFarthest_px, kFarthest_px));
  };
  for (const Contour& contour : outline) {
    for (std::size_t i = 0; i < contour.size(); ++i) {
      const glm::dvec2 a = near(contour[i]), b = near(contour[(i + 1) % contour.size()]);
      if (a.y == b.y) continue;
      edges_.push_back(a.y < b.y ? Edge{a.x, a.y, b.x, b.y, 1} : Edge{b.x, b.y, a.x, a.y, -1});
      top = std::min(top, edges_.back().top_y), bottom = std::max(bottom, edges_.back().bottom_y);
    }
  }
  if (edges_.empty()) return;
  first_row_ = static_cast<int>(std::floor(top)), end_row_ = static_cast<int>(std::ceil(bottom));
  // Rows below and above every picture have no lists.
  first_row_ = std::max(first_row_, 0), end_row_ = std::clamp(end_row_, first_row_, 1 << 16);
  in_rows_.resize(static_cast<std::size_t>(end_row_ - first_row_));
  for (std::uint32_t i = 0; i < edges_.size(); ++i) {
    const int begin = std::max(static_cast<int>(std::floor(edges_[i].top_y)), first_row_);
    const int end = std::min(static_cast<int>(std::ceil(edges_[i].bottom_y)), end_row_);
    for (int row = begin; row < end; ++row) in_rows_[static_cast<std::size_t>(row - first_row_)].push_back(i);
  }
}

void Coverage::addRow(int row, int first_column, std::span<std::int32_t> sums) const {
  if (row < first_row_ || row >= end_row_) return;
  std::vector<std::pair<std::int64_t, int>> crossings;
  for (int line = 0; line < kLines; ++line) {
    const double y = row + (line + 0.5) / kLines;
    crossings.clear();
    for (const std::uint32_t i : in_rows_[static_cast<std::size_t>(row - first_row_)]) {
      const Edge& edge = edges_[i];
      if (y < edge.top_y || y >= edge.bottom_y) continue;
      const double x = edge.top_x + (y - edge.top_y) * ((edge.bottom_x - edge.top_x) / (edge.bottom_y - edge.top_y));
      crossings.emplace_back(std::llround(x * kSteps), edge.winding);
    }
    std::ranges::sort(crossings);
    int winding = 0;
    for (std::size_t i = 0; i < crossings.size(); ++i) {
      const int before = std::exchange(winding, winding + crossings[i].second);
      if (before != 0) addInterval(crossings[i - 1].first, crossings[i].first, first_column, sums);
    }
  }
}

}  // namespace kiln
