// Method. Sampling halves each span between two nodes until straight lines are close enough at the quarter points. At a
// jump, two points share a value: the curve's limit from below, and its value from there on.
#include "scene/transfer/color_map.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "image/srgb.h"

namespace kiln {
namespace {

// A midpoint at the end of a span would leave no room for half of the curve.
constexpr double kLeastMidpoint = 1e-5;
// VTK treats sharper curves as steps, and flatter curves as straight lines.
constexpr double kStep = 0.99, kStraight = 0.01;
constexpr int kMostHalvings = 12;

template <class Node>
std::size_t firstNodeNotBelow(const std::vector<Node>& nodes, double value) {
  const auto found =
      std::lower_bound(nodes.begin(), nodes.end(), value, [](const Node& node, double v) { return node.value < v; });
  return static_cast<std::size_t>(found - nodes.begin());
}

double clampedMidpoint(const OpacityNode& node) {
  return std::clamp(node.midpoint, kLeastMidpoint, 1 - kLeastMidpoint);
}

double between(const OpacityNode& a, const OpacityNode& b, double s) {
  const double midpoint = clampedMidpoint(a);
  s = s < midpoint ? 0.5 * s / midpoint : 0.5 + 0.5 * (s - midpoint) / (1 - midpoint);
  if (a.sharpness > kStep) return s < 0.5 ? a.opacity : b.opacity;
  if (a.sharpness < kStraight) return std::lerp(a.opacity, b.opacity, s);
  const double steeper = 1 + 10 * a.sharpness;
  s = s < 0.5 ? 0.5 * std::pow(2 * s, steeper) : 1 - 0.5 * std::pow(2 * (1 - s), steeper);
  // Hermite curve with equal slopes at both ends.
  const double way = s * s * (3 - 2 * s) + (1 - a.sharpness) * (s - 3 * s * s + 2 * s * s * s);
  return std::lerp(a.opacity, b.opacity, std::clamp(way, 0.0, 1.0));
}

class Sampler {
 public:
  Sampler(const ColorMap& colors, const OpacityCurve& opacity) : colors_(colors), opacity_(opacity) {}

  std::vector<TransferPoint> points() {
    const std::vector<double> at = breaks();
    points_.push_back(at_(at.front()));
    for (std::size_t i = 1; i < at.size(); ++i) {
      // Evaluates just inside the span: its own curve, without the values at its ends.
      const TransferPoint first = at_(std::nextafter(at[i - 1], at[i]), at[i - 1]);
      const TransferPoint last = at_(std::nextafter(at[i], at[i - 1]), at[i]);
      if (!near(points_.back(), first)) points_.push_back(first);
      span(first, last, kMostHalvings);
      const TransferPoint end = at_(at[i]);
      if (!near(end, last)) points_.push_back(last);
      points_.push_back(end);
    }
    return std::move(points_);
  }

 private:
  // Values at which a curve may have a corner or a jump.
  std::vector<double> breaks() const {
    std::vector<double> out;
    for (const ColorNode& node : colors_.nodes) out.push_back(node.value);
    for (std::size_t i = 0; i < opacity_.nodes.size(); ++i) {
      const OpacityNode& node = opacity_.nodes[i];
      out.push_back(node.value);
      if (i + 1 < opacity_.nodes.size())
        out.push_back(std::lerp(node.value, opacity_.nodes[i + 1].value, clampedMidpoint(node)));
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }

  TransferPoint at_(double value) const { return at_(value, value); }
  TransferPoint at_(double value, double shown) const {
    return {shown, linearFromSrgb(colors_.at(value)), opacity_.at(value)};
  }

  static bool near(const TransferPoint& a, const TransferPoint& b) {
    if (std::abs(a.opacity - b.opacity) > kSampledOpacityError) return false;
    for (int channel = 0; channel < 3; ++channel) {
      if (std::abs(srgbFromLinear(a.color[channel]) - srgbFromLinear(b.color[channel])) > kSampledColorError)
        return false;
    }
    return true;
  }

  // Adds the points strictly between two neighbours.
  void span(const TransferPoint& a, const TransferPoint& b, int halvings) {
    bool straight = true;
    for (const double t : {0.25, 0.5, 0.75}) {
      const TransferPoint line{0, glm::mix(a.color, b.color, t), std::lerp(a.opacity, b.opacity, t)};
      straight = straight && near(line, at_(std::lerp(a.value, b.value, t)));
    }
    if (straight || halvings == 0) return;
    const TransferPoint middle = at_(0.5 * (a.value + b.value));
    if (!(a.value < middle.value && middle.value < b.value)) return;
    span(a, middle, halvings - 1);
    points_.push_back(middle);
    span(middle, b, halvings - 1);
  }

  const ColorMap& colors_;
  const OpacityCurve& opacity_;
  std::vector<TransferPoint> points_;
};

template <class Node>
void stretchValues(std::vector<Node>& nodes, const ValueRange& from, const ValueRange& to) {
  for (Node& node : nodes) node.value = std::lerp(to.lo, to.hi, (node.value - from.lo) / (from.hi - from.lo));
}

}  // namespace

glm::dvec3 ColorMap::at(double value) const {
  const std::size_t upper = firstNodeNotBelow(nodes, value);
  if (upper == nodes.size()) return nodes.back().srgb;
  if (upper == 0 || nodes[upper].value == value) return nodes[upper].srgb;
  const ColorNode &a = nodes[upper - 1], &b = nodes[upper];
  return interpolated(space, a.srgb, b.srgb, (value - a.value) / (b.value - a.value));
}

double OpacityCurve::at(double value) const {
  const std::size_t upper = firstNodeNotBelow(nodes, value);
  if (upper == nodes.size()) return nodes.back().opacity;
  if (upper == 0 || nodes[upper].value == value) return nodes[upper].opacity;
  const OpacityNode &a = nodes[upper - 1], &b = nodes[upper];
  return between(a, b, (value - a.value) / (b.value - a.value));
}

std::vector<TransferPoint> sampled(const ColorMap& colors, const OpacityCurve& opacity) {
  return Sampler(colors, opacity).points();
}

void stretch(ColorMap& colors, const ValueRange& from, const ValueRange& to) { stretchValues(colors.nodes, from, to); }
void stretch(OpacityCurve& opacity, const ValueRange& from, const ValueRange& to) {
  stretchValues(opacity.nodes, from, to);
}
void stretch(std::vector<TransferPoint>& points, const ValueRange& from, const ValueRange& to) {
  stretchValues(points, from, to);
}
void stretch(std::vector<IsoSurface>& surfaces, const ValueRange& from, const ValueRange& to) {
  stretchValues(surfaces, from, to);
}

}  // namespace kiln
