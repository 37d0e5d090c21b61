#include "engine/pixel/voxels/plane_table.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

namespace kiln {
namespace {

// Nodes of regions along each axis, and of a function of gradients alone.
constexpr int kRegionNodes = 512, kGradientNodes = 4096;

// Position of a grid's nodes.
struct Nodes {
  int columns = 0, rows = 0;
  glm::dvec2 first{0}, last{0};
  double valueOf(int column) const { return std::lerp(first.x, last.x, column / std::max(columns - 1.0, 1.0)); }
  double gradientOf(int row) const { return std::lerp(first.y, last.y, row / std::max(rows - 1.0, 1.0)); }
};

Nodes nodesOf(const TransferFunction& function) {
  if (const GradientTable& table = function.table; table.columns > 0)
    return {table.columns, table.rows, {table.values.x, table.gradients.x}, {table.values.y, table.gradients.y}};
  if (!function.regions.empty()) {
    constexpr double kMost = std::numeric_limits<double>::max();
    glm::dvec2 first(kMost), last(-kMost);
    for (const GradientRegion& region : function.regions) {
      first = glm::min(first, glm::dvec2(region.values.x, region.gradients.x));
      last = glm::max(last, glm::dvec2(region.values.y, region.gradients.y));
    }
    // Nodes outside the regions: the last nodes extend.
    const glm::dvec2 beside = (last - first) / (kRegionNodes - 3.0);
    first -= beside;
    first.y = std::max(first.y, 0.0);
    return {kRegionNodes, kRegionNodes, first, last + beside};
  }
  const auto& points = function.gradient_opacity;
  if (points.empty()) return {};
  return {1, kGradientNodes, {0, points.front().gradient}, {0, points.back().gradient}};
}

bool hasColors(const TransferFunction& function) {
  return std::any_of(function.regions.begin(), function.regions.end(),
                     [](const GradientRegion& region) { return region.color.has_value(); });
}

// Nodes a distance of one, or none if all nodes are in one place.
double perUnit(int nodes, double first, double last) { return last > first ? (nodes - 1) / (last - first) : 0; }

// A node's colours of regions times their weights, and the weight of the value's colour.
void colorOf(const TransferFunction& function, double value, double gradient, float* out) {
  double color[4] = {0, 0, 0, 0}, sum = 0;
  for (const GradientRegion& region : function.regions) {
    const double share = region.at(value, gradient);
    sum += share;
    if (!region.color) color[3] += share;
    for (int c = 0; c < 3 && region.color; ++c) color[c] += share * (*region.color)[c];
  }
  if (!(sum > 0)) color[3] = sum = 1;
  for (int c = 0; c < 4; ++c) out[c] = static_cast<float>(color[c] / sum);
}

}  // namespace

PlaneTable::PlaneTable(const TransferFunction& function) {
  const Nodes nodes = nodesOf(function);
  if (nodes.columns == 0) return;
  columns_ = nodes.columns, rows_ = nodes.rows, first_ = nodes.first;
  per_ = {perUnit(columns_, nodes.first.x, nodes.last.x), perUnit(rows_, nodes.first.y, nodes.last.y)};
  const bool colored = hasColors(function);
  const auto count = static_cast<std::size_t>(stride()) * static_cast<std::size_t>(rows_ + 1);
  factors_.reserve(count);
  if (colored) colors_.reserve(4 * count);
  std::vector<int> shown(static_cast<std::size_t>(stride()), 0);
  for (int y = 0; y <= rows_; ++y) {
    const double gradient = nodes.gradientOf(std::min(y, rows_ - 1));
    for (int x = 0; x <= columns_; ++x) {
      const double value = nodes.valueOf(std::min(x, columns_ - 1));
      factors_.push_back(static_cast<float>(function.gradientFactor(value, gradient)));
      if (factors_.back() > 0) shown[static_cast<std::size_t>(x)] = 1;
      if (!colored) continue;
      colors_.resize(colors_.size() + 4);
      colorOf(function, value, gradient, &colors_.back() - 3);
    }
  }
  shown_before_.assign(1, 0);
  for (const int column : shown) shown_before_.push_back(shown_before_.back() + column);
}

bool PlaneTable::shows(double lo, double hi) const {
  const double last = columns_ - 1;
  const auto from = static_cast<std::size_t>(std::floor(std::clamp((lo - first_.x) * per_.x, 0.0, last)));
  const auto to = static_cast<std::size_t>(std::ceil(std::clamp((hi - first_.x) * per_.x, 0.0, last)));
  return shown_before_[to + 1] > shown_before_[from];
}

}  // namespace kiln
