#include "annotate/volume_outline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <optional>

#include "annotate/drawing.h"

namespace kiln {
namespace {

constexpr double kSameShare = 8e-9;  // unit: the box's diagonal

// unit: the font's size.
constexpr double kDash = 0.5, kDashGap = 0.45;
constexpr double kHiddenOpacity = 0.55, kEdgeRimOpacity = 0.35;

// Returns the half-spaces of the clipped box in index space; nothing if the region holds nothing of the box.
std::vector<glm::dvec4> halfSpacesOf(const VolumeGeometry& volume, const Clipping& clipping) {
  glm::dvec3 lo(-0.5), hi(0.0);
  for (int axis = 0; axis < 3; ++axis) {
    hi[axis] = static_cast<double>(volume.dims[axis]) - 0.5;
    if (!clipping.region) continue;
    lo[axis] = std::max(lo[axis], static_cast<double>(clipping.region->lo[axis]) - 0.5);
    hi[axis] = std::min(hi[axis], static_cast<double>(clipping.region->hi[axis]) - 0.5);
    if (!(lo[axis] < hi[axis])) return {};
  }
  std::vector<glm::dvec4> out;
  addBox(lo, hi, out);
  for (const ClipPlane& plane : clipping.planes)
    out.push_back(inIndexSpace(glm::dvec4(plane.normal, plane.offset), volume.world_from_index));
  return out;
}

// A line as the picture shows it.
struct SeenLine {
  glm::dvec2 a_px, b_px;
  double a_depth, b_depth;
};

std::optional<SeenLine> seen(const Edge& line, const View& view, double nearest) {
  glm::dvec3 a(view.view_from_world * glm::dvec4(line.first, 1)), b(view.view_from_world * glm::dvec4(line.second, 1));
  if (view.projection == Projection::kPerspective) {
    if (a.z < nearest && b.z < nearest) return std::nullopt;
    const glm::dvec3 at = a.z == b.z ? a : a + (nearest - a.z) / (b.z - a.z) * (b - a);
    if (a.z < nearest) a = at;
    if (b.z < nearest) b = at;
  }
  return SeenLine{view.pixelOf(a), view.pixelOf(b), a.z + view.origin_depth, b.z + view.origin_depth};
}

// Returns the part of the line inside the picture and its border, as positions along the line: begin and end.
std::optional<std::pair<double, double>> within(const SeenLine& line, const ImageSize& size, double border) {
  double begin = 0, end = 1;
  const glm::dvec2 hi(size.width, size.height);
  for (int axis = 0; axis < 2; ++axis) {
    const double from = line.a_px[axis], step = line.b_px[axis] - from;
    for (const auto& [limit, sign] : {std::pair{-border, 1.0}, std::pair{hi[axis] + border, -1.0}}) {
      const double inside = sign * (from - limit), change = sign * step;
      if (change == 0 && inside < 0) return std::nullopt;
      if (change > 0) begin = std::max(begin, -inside / change);
      if (change < 0) end = std::min(end, -inside / change);
    }
  }
  if (!(begin < end)) return std::nullopt;
  return std::pair{begin, end};
}

}  // namespace

std::vector<Edge> edgesOf(const VolumeGeometry& volume, const Clipping& clipping) {
  const auto corners = volume.corners();
  const double same = kSameShare * glm::distance(corners.front(), corners.back());
  const auto near = [&](const glm::dvec3& p, const glm::dvec3& q) { return glm::distance(p, q) <= same; };
  std::vector<Edge> out;
  for (const Edge& edge : edgesOf(halfSpacesOf(volume, clipping))) {
    const glm::dvec3 a = volume.worldOf(edge.first), b = volume.worldOf(edge.second);
    const auto is_same = [&](const Edge& other) {
      return (near(other.first, a) && near(other.second, b)) || (near(other.first, b) && near(other.second, a));
    };
    if (!near(a, b) && std::none_of(out.begin(), out.end(), is_same)) out.push_back({a, b});
  }
  return out;
}

std::vector<Shape> outlineOfVolume(const AnnotatedPicture& picture, const Style& style) {
  const View& view = picture.view;
  const auto corners = picture.box.corners();
  const double nearest = 1e-4 * glm::distance(corners.front(), corners.back());
  std::vector<Shape> rims, lines;
  for (const Edge& edge : edgesOf(picture.box, picture.clipping)) {
    const std::optional<SeenLine> line = seen(edge, view, nearest);
    if (!line) continue;
    const auto shown = within(*line, view.size, style.em);
    if (!shown) continue;
    const auto at = [&](double t) { return line->a_px + t * (line->b_px - line->a_px); };
    DepthTest test{line->a_px,
                   line->b_px,
                   line->a_depth,
                   line->b_depth,
                   view.projection == Projection::kPerspective,
                   false,
                   glm::length(picture.box.spacing())};
    const Outline whole = stroke(at(shown->first), at(shown->second), style.line);
    const Outline rim = stroke(at(shown->first), at(shown->second), style.line + style.halo);
    if (!picture.has_depth) {
      rims.push_back({rim, style.rim, kEdgeRimOpacity});
      lines.push_back({whole, style.ink});
      continue;
    }
    rims.push_back({rim, style.rim, kEdgeRimOpacity, test});
    lines.push_back({whole, style.ink, 1, test});
    test.shows_hidden = true;
    const double length = glm::distance(line->a_px, line->b_px), period = (kDash + kDashGap) * style.em / length;
    Outline dashes;
    for (double n = std::floor(shown->first / period); n * period < shown->second; ++n) {
      const double begin = std::max(n * period, shown->first);
      const double end = std::min(n * period + kDash * style.em / length, shown->second);
      if (begin < end) append(dashes, stroke(at(begin), at(end), style.line));
    }
    lines.push_back({std::move(dashes), style.ink, kHiddenOpacity, test});
  }
  rims.insert(rims.end(), lines.begin(), lines.end());
  return rims;
}

}  // namespace kiln
