#include "scene/transfer_function.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec4.hpp>
#include <limits>

namespace kiln {

namespace {

auto firstFrom(const std::vector<LabelLook>& labels, double value) {
  return std::lower_bound(labels.begin(), labels.end(), value,
                          [](const LabelLook& look, double v) { return look.label < v; });
}

}  // namespace

bool TransferFunction::labelsShownIn(double lo, double hi) const {
  for (auto look = firstFrom(labels, lo); look != labels.end() && look->label <= hi; ++look) {
    if (look->opacity > 0) return true;
  }
  return false;
}

Classified TransferFunction::at(double value) const {
  if (!labels.empty()) {
    const auto look = firstFrom(labels, value);
    if (look == labels.end() || look->label != value) return {glm::dvec3(0), 0};
    return {look->color, look->opacity};
  }
  if (points.empty() || std::isnan(value)) return {glm::dvec3(0), 0};
  const auto upper = std::upper_bound(points.begin(), points.end(), value,
                                      [](double v, const TransferPoint& point) { return v < point.value; });
  if (upper == points.begin()) return {upper->color, upper->opacity};
  const TransferPoint& below = *(upper - 1);
  if (upper == points.end() || value == below.value) return {below.color, below.opacity};
  const double t = (value - below.value) / (upper->value - below.value);
  return {(1 - t) * below.color + t * upper->color, (1 - t) * below.opacity + t * upper->opacity};
}

double TransferFunction::gradientFactor(double gradient) const {
  if (gradient_opacity.empty()) return 1;
  const auto upper = std::upper_bound(gradient_opacity.begin(), gradient_opacity.end(), gradient,
                                      [](double g, const GradientPoint& point) { return g < point.gradient; });
  if (upper == gradient_opacity.begin()) return upper->factor;
  const GradientPoint& below = *(upper - 1);
  if (upper == gradient_opacity.end()) return below.factor;
  return std::lerp(below.factor, upper->factor, (gradient - below.gradient) / (upper->gradient - below.gradient));
}

TransferFunction inWorld(TransferFunction function, double world_per_own) {
  function.unit *= world_per_own;
  for (GradientPoint& point : function.gradient_opacity) point.gradient /= world_per_own;
  return function;
}

double extinctionOf(double opacity, double unit) {
  // The clamp keeps a fully opaque point finite (DESIGN.md §6).
  return -std::log1p(-std::min(opacity, 0.9999)) / unit;
}

double steepnessOf(const TransferFunction& function, double spacing, const ValueRange& range) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  if (!function.labels.empty() || range.empty()) return kInfinite;
  const double unit = function.unitIn(spacing);
  // Optical depth, and light, of a voxel.
  const auto shown = [&](const TransferPoint& point) {
    const double depth = extinctionOf(point.opacity, unit) * spacing;
    return glm::dvec4(depth * point.color, depth);
  };
  double most_depth = 0, most_change = 0;
  const std::vector<TransferPoint>& points = function.points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const glm::dvec4 here = shown(points[i]);
    most_depth = std::max(most_depth, here.w);
    if (i == 0 || points[i].value < range.lo || points[i - 1].value > range.hi) continue;
    const glm::dvec4 change = glm::abs(here - shown(points[i - 1]));
    const double most = std::max({change.r, change.g, change.b, change.a});
    const double width = points[i].value - points[i - 1].value;
    if (most > 0) most_change = std::max(most_change, width > 0 ? most * (range.hi - range.lo) / width : kInfinite);
  }
  return std::max(most_depth, most_change) + (function.gradient_opacity.empty() ? 0 : most_depth);
}

}  // namespace kiln
