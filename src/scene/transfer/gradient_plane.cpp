// Factors of opacity over the plane of values and gradient lengths.

#include <algorithm>
#include <cmath>

#include "scene/transfer/transfer_function.h"

namespace kiln {
namespace {

// Rises from 0 at distance 0 to 1 at distance `rise`; a distance below 0 is outside.
double risen(double distance, double rise) {
  if (!(distance >= 0)) return 0;
  return distance < rise ? distance / rise : 1;
}

// The node before a place, and the share of the next node.
struct NodeBefore {
  int first;
  double share;
};
NodeBefore placeIn(const glm::dvec2& limits, int nodes, double at) {
  if (nodes < 2 || !(limits.y > limits.x)) return {0, 0};
  const double place = std::clamp((at - limits.x) / (limits.y - limits.x), 0.0, 1.0) * (nodes - 1);
  const int first = std::min(static_cast<int>(place), nodes - 2);
  return {first, place - first};
}

}  // namespace

double GradientRegion::at(double value, double gradient) const {
  const double middle = 0.5 * (values.x + values.y), half = 0.5 * (values.y - values.x);
  const double height = gradients.y - gradients.x;
  if (!(gradient >= gradients.x && gradient <= gradients.y)) return 0;
  if (shape == RegionShape::kTriangle) {
    const double width = half * (gradient - gradients.x) / height;
    return opacity * risen(width - std::abs(value - middle), softness * width);
  }
  const double across = risen(half - std::abs(value - middle), softness * half);
  const double above = gradients.x > 0 ? risen(gradient - gradients.x, 0.5 * softness * height) : 1;
  return opacity * across * std::min(above, risen(gradients.y - gradient, 0.5 * softness * height));
}

double GradientTable::at(double value, double gradient) const {
  const NodeBefore x = placeIn(values, columns, value), y = placeIn(gradients, rows, gradient);
  const auto node = [&](int column, int row) {
    return static_cast<double>(
        opacity[static_cast<std::size_t>(std::min(row, rows - 1)) * static_cast<std::size_t>(columns) +
                static_cast<std::size_t>(std::min(column, columns - 1))]);
  };
  const auto along = [&](int row) { return std::lerp(node(x.first, row), node(x.first + 1, row), x.share); };
  return std::lerp(along(y.first), along(y.first + 1), y.share);
}

}  // namespace kiln
