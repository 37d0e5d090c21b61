#include "scene/transfer/transfer_function.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec4.hpp>
#include <limits>

namespace kiln {
namespace {

auto firstFrom(const std::vector<LabelStyle>& labels, double value) {
  return std::lower_bound(labels.begin(), labels.end(), value,
                          [](const LabelStyle& style, double v) { return style.label < v; });
}

// Linear between points; the end points extend.
double factorOf(const std::vector<GradientPoint>& points, double gradient) {
  if (points.empty()) return 1;
  const auto upper = std::upper_bound(points.begin(), points.end(), gradient,
                                      [](double g, const GradientPoint& point) { return g < point.gradient; });
  if (upper == points.begin()) return upper->factor;
  const GradientPoint& below = *(upper - 1);
  if (upper == points.end()) return below.factor;
  return std::lerp(below.factor, upper->factor, (gradient - below.gradient) / (upper->gradient - below.gradient));
}

}  // namespace

bool TransferFunction::hasLabel(double label) const {
  const auto style = firstFrom(labels, label);
  return style != labels.end() && style->label == label;
}

bool TransferFunction::labelsShownIn(double lo, double hi) const {
  for (auto style = firstFrom(labels, lo); style != labels.end() && style->label <= hi; ++style) {
    if (style->opacity > 0) return true;
  }
  return false;
}

bool TransferFunction::surfacesCrossedIn(double lo, double hi) const {
  auto surface =
      std::upper_bound(surfaces.begin(), surfaces.end(), lo, [](double v, const IsoSurface& s) { return v < s.value; });
  for (; surface != surfaces.end() && surface->value <= hi; ++surface) {
    if (surface->opacity > 0) return true;
  }
  return false;
}

Classified TransferFunction::at(double value) const {
  if (!labels.empty()) {
    const auto style = firstFrom(labels, value);
    if (style == labels.end() || style->label != value) return {glm::dvec3(0), 0};
    return {style->color, style->opacity};
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

double TransferFunction::gradientFactor(double value, double gradient) const {
  if (table.columns > 0) return table.at(value, gradient);
  if (!regions.empty()) {
    double most = 0;
    for (const GradientRegion& region : regions) most = std::max(most, region.at(value, gradient));
    return most;
  }
  return factorOf(gradient_opacity, gradient);
}

Classified TransferFunction::at(double value, double gradient) const {
  Classified out = at(value);
  if (!(out.opacity > 0)) return out;
  out.opacity *= gradientFactor(value, gradient);
  glm::dvec3 mixed(0);
  double weight = 0;
  for (const GradientRegion& region : regions) {
    const double share = region.at(value, gradient);
    mixed += share * region.color.value_or(out.color);
    weight += share;
  }
  if (weight > 0) out.color = mixed / weight;
  return out;
}

Shading shadingOf(const TransferFunction& function, Shading light) {
  light.phong = light.phong && (function.shaded || function.scattering);
  light.scattering = function.scattering;
  return light;
}

TransferFunction inWorld(TransferFunction function, double world_per_own) {
  function.unit *= world_per_own;
  for (GradientPoint& point : function.gradient_opacity) point.gradient /= world_per_own;
  for (GradientRegion& region : function.regions) region.gradients /= world_per_own;
  function.table.gradients /= world_per_own;
  return function;
}

double extinctionOf(double opacity, double unit) {
  // The clamp keeps the extinction of an opaque point finite.
  return -std::log1p(-std::min(opacity, 0.9999)) / unit;
}

}  // namespace kiln
