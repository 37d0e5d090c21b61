#include "engine/projection/silhouette.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <limits>

#include "scene/half_spaces.h"

namespace kiln {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// A covered share below this is none: its middle has no precision, and 16 bits of alpha hold nothing of it.
constexpr double kLeastCovered = 1e-6;

// Returns the half-spaces (normal, offset) whose intersection is shown.
std::vector<glm::dvec4> shownHalfSpaces(const Projector& projector, const ClipRegion& clip, const glm::dvec3& end) {
  std::vector<glm::dvec4> out = clip.halfSpaces();
  addBox(glm::dvec3(-0.5), end, out);
  if (projector.perspective()) {
    const double at_origin = projector.viewOfIndex(glm::dvec3(0)).z;
    out.emplace_back(projector.axis(0).z, projector.axis(1).z, projector.axis(2).z, at_origin - projector.nearDepth());
  }
  for (glm::dvec4& plane : out) plane /= glm::length(glm::dvec3(plane));
  return out;
}

double leftTurn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Source: Andrew 1979, monotone chain.
std::vector<glm::dvec2> convexHull(std::vector<glm::dvec2> points) {
  std::sort(points.begin(), points.end(),
            [](const glm::dvec2& a, const glm::dvec2& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return {};
  std::vector<glm::dvec2> out;
  const auto addChain = [&](auto begin, auto end) {
    const std::size_t first = out.size();
    for (auto point = begin; point != end; ++point) {
      while (out.size() >= first + 2 && leftTurn(out[out.size() - 2], out.back(), *point) <= 0) out.pop_back();
      out.push_back(*point);
    }
    out.pop_back();  // the first point of the next chain
  };
  addChain(points.begin(), points.end());
  addChain(points.rbegin(), points.rend());
  return out.size() < 3 ? std::vector<glm::dvec2>() : out;
}

int toInt(double v) { return static_cast<int>(std::clamp(v, -1e9, 1e9)); }

// Area of a part of a pixel's square, and its moments about the square's corner.
struct Moments {
  double area = 0, x = 0, y = 0;

  // Adds `sign` times the part between y = 0 and a line from (x0, y0) to (x1, y1) inside the square.
  void addStraight(double sign, double x0, double y0, double x1, double y1) {
    const double width = sign * (x1 - x0);
    area += width * (y0 + y1) / 2;
    x += width * (x0 * (2 * y0 + y1) + x1 * (y0 + 2 * y1)) / 6;
    y += width * (y0 * y0 + y0 * y1 + y1 * y1) / 6;
  }

  // Adds what lies in the square below the edge, with the sign of the edge's direction along x.
  void addEdge(const glm::dvec2& from, const glm::dvec2& to) {
    const double sign = from.x < to.x ? 1 : -1;
    const glm::dvec2 &left = sign > 0 ? from : to, &right = sign > 0 ? to : from;
    const double first = std::max(left.x, 0.0), last = std::min(right.x, 1.0);
    if (!(first < last)) return;
    const double slope = (right.y - left.y) / (right.x - left.x);
    // The edge inside the square has up to three straight parts, which meet where it crosses y = 0 and y = 1.
    std::array<double, 4> at{first, last, last, last};
    if (slope != 0) {
      at[1] = std::clamp(left.x - left.y / slope, first, last);
      at[2] = std::clamp(left.x + (1 - left.y) / slope, first, last);
      if (at[1] > at[2]) std::swap(at[1], at[2]);
    }
    const auto height = [&](double at_x) { return std::clamp(left.y + slope * (at_x - left.x), 0.0, 1.0); };
    for (std::size_t i = 0; i + 1 < at.size(); ++i) {
      if (at[i] < at[i + 1]) addStraight(sign, at[i], height(at[i]), at[i + 1], height(at[i + 1]));
    }
  }
};

}  // namespace

Silhouette::Silhouette(const Projector& projector, const ClipRegion& clip, const glm::dvec3& end) {
  std::vector<glm::dvec2> points;
  for (const auto& [begin, finish] : edgesOf(shownHalfSpaces(projector, clip, end))) {
    for (const glm::dvec3& corner : {begin, finish}) points.push_back(projector.pixelOf(projector.viewOfIndex(corner)));
  }
  corners_ = convexHull(std::move(points));
}

Silhouette::Span Silhouette::columnsAt(double y) const {
  Span out{kUnbounded, -kUnbounded};
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const glm::dvec2 &a = corners_[i], &b = corners_[i + 1 < corners_.size() ? i + 1 : 0];
    if (std::min(a.y, b.y) > y || std::max(a.y, b.y) < y) continue;
    const bool level = a.y == b.y;
    const double at_a = level ? a.x : std::lerp(a.x, b.x, (y - a.y) / (b.y - a.y)), at_b = level ? b.x : at_a;
    out = {std::min({out.lo, at_a, at_b}), std::max({out.hi, at_a, at_b})};
  }
  return out;
}

Silhouette::Row Silhouette::row(int y) const {
  Row out;
  out.outline_ = this;
  out.y_ = y;
  const Span above = columnsAt(y), below = columnsAt(y + 1);
  Span touched{std::min(above.lo, below.lo), std::max(above.hi, below.hi)};
  for (const glm::dvec2& corner : corners_) {
    if (corner.y <= y || corner.y >= y + 1) continue;
    touched = {std::min(touched.lo, corner.x), std::max(touched.hi, corner.x)};
  }
  if (touched.empty()) return out;
  out.first_ = toInt(std::floor(touched.lo)), out.end_ = toInt(std::ceil(touched.hi));
  if (above.empty() || below.empty()) return out;
  out.whole_first_ = toInt(std::ceil(std::max(above.lo, below.lo)));
  out.whole_end_ = toInt(std::floor(std::min(above.hi, below.hi)));
  return out;
}

Silhouette::Part Silhouette::Row::at(int x) const {
  if (x < first_ || x >= end_) return {};
  if (x >= whole_first_ && x < whole_end_) return {1, {x + 0.5, y_ + 0.5}};
  return outline_->partOf(x, y_);
}

Silhouette::Part Silhouette::partOf(int x, int y) const {
  const glm::dvec2 corner(x, y);
  Moments sum;
  for (std::size_t i = 0; i < corners_.size(); ++i)
    sum.addEdge(corners_[i] - corner, corners_[i + 1 < corners_.size() ? i + 1 : 0] - corner);
  // The sign is the direction of the polygon.
  const double area = std::abs(sum.area);
  if (area < kLeastCovered) return {};
  return {std::min(area, 1.0), corner + glm::clamp(glm::dvec2(sum.x, sum.y) / sum.area, 0.0, 1.0)};
}

}  // namespace kiln
