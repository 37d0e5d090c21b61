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
  // The clamp keeps the extinction of an opaque point finite.
  return -std::log1p(-std::min(opacity, 0.9999)) / unit;
}

}  // namespace kiln
