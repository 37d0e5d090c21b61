#include "annotate/outline.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

namespace kiln {
namespace {

// Contours wind alike: overlapping contours unite.
Contour wound(Contour contour) {
  double area = 0;
  for (std::size_t i = 0; i < contour.size(); ++i) {
    const glm::dvec2 &a = contour[i], &b = contour[(i + 1) % contour.size()];
    area += a.x * b.y - a.y * b.x;
  }
  if (area < 0) std::reverse(contour.begin(), contour.end());
  return contour;
}

}  // namespace

void append(Outline& outline, const Outline& more) { outline.insert(outline.end(), more.begin(), more.end()); }

Contour rectangle(const glm::dvec2& lo, const glm::dvec2& hi) { return {lo, {hi.x, lo.y}, hi, {lo.x, hi.y}}; }

Contour disc(const glm::dvec2& centre, double radius, int corners) {
  Contour out;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    out.push_back(centre + radius * glm::dvec2(std::cos(angle), std::sin(angle)));
  }
  return out;
}

Outline stroke(const glm::dvec2& a, const glm::dvec2& b, double width) {
  const double length = glm::distance(a, b);
  if (!(length > 0)) return {};
  const glm::dvec2 along = (b - a) / length, across = 0.5 * width * glm::dvec2(-along.y, along.x);
  return {wound({a - across, b - across, b + across, a + across})};
}

Outline arrow(const glm::dvec2& a, const glm::dvec2& b, double width, double head_length, double head_width) {
  const double length = glm::distance(a, b);
  if (!(length > 0)) return {};
  const glm::dvec2 along = (b - a) / length, across(-along.y, along.x);
  const double head = std::min(head_length, length);
  const glm::dvec2 neck = b - head * along;
  Outline out = stroke(a, neck, width);
  out.push_back(wound({neck - 0.5 * head_width * across, b, neck + 0.5 * head_width * across}));
  return out;
}

Outline grown(const Outline& outline, double distance) {
  constexpr int kCorners = 8;
  Outline out;
  for (const Contour& contour : outline) {
    out.push_back(contour);
    for (std::size_t i = 0; i < contour.size(); ++i) {
      append(out, stroke(contour[i], contour[(i + 1) % contour.size()], 2 * distance));
      out.push_back(disc(contour[i], distance, kCorners));
    }
  }
  return out;
}

}  // namespace kiln
