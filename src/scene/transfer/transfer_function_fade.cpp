#include "scene/transfer/transfer_function_fade.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <string>

namespace kiln {
namespace {

// Returns the values of both lists, each value once.
template <class Points, class ValueOf>
std::vector<double> valuesOf(const Points& a, const Points& b, const ValueOf& value_of) {
  std::vector<double> out;
  for (const auto* points : {&a, &b}) {
    for (const auto& point : *points) out.push_back(value_of(point));
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

// Returns the limit from below: the function may step at a value.
Classified before(const TransferFunction& function, double value) {
  for (const TransferPoint& point : function.points) {
    if (point.value == value) return {point.color, point.opacity};
  }
  return function.at(value);
}

double inUnit(double opacity, double from, double to) {
  return from == to ? opacity : 1 - std::pow(1 - opacity, to / from);
}

// Divides the spaces between values: opacity that is linear per one unit of length is curved per another. Between units
// of ratio ten, 16 parts miss at most 0.03 of an opacity of 0.99 and 0.0001 of 0.65; one part misses 0.15 and 0.012.
std::vector<double> divided(const std::vector<double>& values) {
  constexpr std::size_t kMostParts = 16, kMostValues = 4096;
  const std::size_t parts =
      std::clamp<std::size_t>(kMostValues / std::max<std::size_t>(values.size(), 1), 1, kMostParts);
  std::vector<double> out;
  for (std::size_t i = 0; i + 1 < values.size(); ++i) {
    for (std::size_t part = 0; part < parts; ++part)
      out.push_back(std::lerp(values[i], values[i + 1], static_cast<double>(part) / static_cast<double>(parts)));
  }
  if (!values.empty()) out.push_back(values.back());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

TransferPoint mixedPoint(double value, const Classified& a, const Classified& b, double t) {
  const double opacity_a = (1 - t) * a.opacity, opacity_b = t * b.opacity, opacity = opacity_a + opacity_b;
  const glm::dvec3 color =
      opacity > 0 ? (opacity_a * a.color + opacity_b * b.color) / opacity : glm::mix(a.color, b.color, t);
  return {value, glm::clamp(color, 0.0, 1.0), std::clamp(opacity, 0.0, 1.0)};
}

// Between two functions of equally many surfaces each surface moves. Otherwise surfaces of one function fade out while
// surfaces of the other function fade in.
std::vector<IsoSurface> fadedSurfaces(const TransferFunction& a, const TransferFunction& b, double t) {
  std::vector<IsoSurface> out;
  if (a.surfaces.size() == b.surfaces.size()) {
    for (std::size_t i = 0; i < a.surfaces.size(); ++i) {
      const IsoSurface &from = a.surfaces[i], &to = b.surfaces[i];
      const TransferPoint mixed =
          mixedPoint(std::lerp(from.value, to.value, t), {from.color, from.opacity}, {to.color, to.opacity}, t);
      out.push_back({mixed.value, mixed.color, mixed.opacity});
    }
    return out;
  }
  const auto lookAt = [](const TransferFunction& function, double value) {
    for (const IsoSurface& surface : function.surfaces) {
      if (surface.value == value) return Classified{surface.color, surface.opacity};
    }
    return Classified{glm::dvec3(0), 0};
  };
  for (const double value : valuesOf(a.surfaces, b.surfaces, [](const IsoSurface& s) { return s.value; })) {
    const TransferPoint mixed = mixedPoint(value, lookAt(a, value), lookAt(b, value), t);
    out.push_back({value, mixed.color, mixed.opacity});
  }
  return out;
}

std::string nameOf(double label, const TransferFunction& a, const TransferFunction& b) {
  for (const TransferFunction* const function : {&a, &b}) {
    for (const LabelStyle& style : function->labels) {
      if (style.label == label && !style.name.empty()) return style.name;
    }
  }
  return {};
}

bool same(const Classified& a, const Classified& b) { return a.color == b.color && a.opacity == b.opacity; }

// Fades each label separately; a label of only one function fades in or out.
std::vector<LabelStyle> fadedLabels(const TransferFunction& a, const TransferFunction& b, double t) {
  std::vector<LabelStyle> out;
  for (const double label : valuesOf(a.labels, b.labels, [](const LabelStyle& style) { return style.label; })) {
    Classified at_b = b.at(label);
    at_b.opacity = inUnit(at_b.opacity, b.unit, a.unit);
    const TransferPoint mixed = mixedPoint(label, a.at(label), at_b, t);
    out.push_back({label, nameOf(label, a, b), mixed.color, mixed.opacity});
  }
  return out;
}

// Points fade into points, and regions fade out and in. Other changes happen halfway.
void fadePlanes(const TransferFunction& a, const TransferFunction& b, double t, TransferFunction& out) {
  const auto hasPlane = [](const TransferFunction& f) { return f.table.columns > 0 || !f.regions.empty(); };
  if (!hasPlane(a) && !hasPlane(b)) {
    for (const double gradient :
         valuesOf(a.gradient_opacity, b.gradient_opacity, [](const GradientPoint& point) { return point.gradient; }))
      out.gradient_opacity.push_back(
          {gradient, std::lerp(a.gradientFactor(0, gradient), b.gradientFactor(0, gradient), t)});
    return;
  }
  if (!regionsFade(a, b)) {
    const TransferFunction& nearer = t < 0.5 ? a : b;
    out.gradient_opacity = nearer.gradient_opacity;
    out.regions = nearer.regions;
    out.table = nearer.table;
    return;
  }
  const auto add = [&](const std::vector<GradientRegion>& regions, double share) {
    for (GradientRegion region : regions) {
      region.opacity *= share;
      out.regions.push_back(region);
    }
  };
  add(a.regions, 1 - t), add(b.regions, t);
}

}  // namespace

bool regionsFade(const TransferFunction& a, const TransferFunction& b) {
  return a.regions != b.regions && !a.regions.empty() && !b.regions.empty() && a.table.columns + b.table.columns == 0;
}

TransferFunction faded(const TransferFunction& a, const TransferFunction& b, double t) {
  if (t == 0) return a;
  if (t == 1) return b;
  TransferFunction out;
  out.unit = a.unit;
  out.labels = fadedLabels(a, b, t);
  out.surfaces = fadedSurfaces(a, b, t);
  const auto in_a_unit = [&](Classified c) {
    c.opacity = inUnit(c.opacity, b.unit, a.unit);
    return c;
  };
  std::vector<double> values = valuesOf(a.points, b.points, [](const TransferPoint& point) { return point.value; });
  if (a.unit != b.unit) values = divided(values);
  for (const double value : values) {
    const Classified before_a = before(a, value), before_b = before(b, value), at_a = a.at(value), at_b = b.at(value);
    out.points.push_back(mixedPoint(value, before_a, in_a_unit(before_b), t));
    if (!same(before_a, at_a) || !same(before_b, at_b))
      out.points.push_back(mixedPoint(value, at_a, in_a_unit(at_b), t));
  }
  fadePlanes(a, b, t, out);
  const TransferFunction& nearer = t < 0.5 ? a : b;
  out.shaded = nearer.shaded;
  out.scattering = nearer.scattering;
  if (a.scattering && b.scattering)
    out.scattering = {std::lerp(a.scattering->albedo, b.scattering->albedo, t),
                      std::lerp(a.scattering->anisotropy, b.scattering->anisotropy, t)};
  return out;
}

}  // namespace kiln
