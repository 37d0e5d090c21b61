// The box is a list of convex faces. Each plane cuts the faces, and closes the hole with a face of its own.
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

using Face = std::vector<glm::dvec3>;

constexpr double kSameShare = 1e-9;  // of the box's diagonal

// unit: the font's size.
constexpr double kDash = 0.5, kDashGap = 0.45;
constexpr double kHiddenOpacity = 0.55, kEdgeRimOpacity = 0.35;

std::vector<Face> facesOfBox(const VolumeGeometry& volume, const Clipping& clipping) {
  glm::dvec3 lo(-0.5), hi(0.0);
  for (int axis = 0; axis < 3; ++axis) {
    hi[axis] = static_cast<double>(volume.dims[axis]) - 0.5;
    if (!clipping.region) continue;
    lo[axis] = std::max(lo[axis], static_cast<double>(clipping.region->lo[axis]) - 0.5);
    hi[axis] = std::min(hi[axis], static_cast<double>(clipping.region->hi[axis]) - 0.5);
    if (!(lo[axis] < hi[axis])) return {};
  }
  const auto corner = [&](int i) {
    return volume.worldOf({(i & 1) ? hi.x : lo.x, (i & 2) ? hi.y : lo.y, (i & 4) ? hi.z : lo.z});
  };
  constexpr std::array<std::array<int, 4>, 6> kFaces = {
      {{0, 2, 6, 4}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 5, 7, 6}}};
  std::vector<Face> out;
  for (const auto& face : kFaces) out.push_back({corner(face[0]), corner(face[1]), corner(face[2]), corner(face[3])});
  return out;
}

void addApart(const glm::dvec3& point, double same, Face& points) {
  const auto is_same = [&](const glm::dvec3& other) { return glm::distance(point, other) <= same; };
  if (std::none_of(points.begin(), points.end(), is_same)) points.push_back(point);
}

// Sorts the corners of a convex face around its middle.
void sortAround(const glm::dvec3& normal, Face& face) {
  glm::dvec3 middle(0);
  for (const glm::dvec3& point : face) middle += point / static_cast<double>(face.size());
  const glm::dvec3 first = glm::normalize(face.front() - middle), second = glm::cross(normal, first);
  const auto angle = [&](const glm::dvec3& p) {
    return std::atan2(glm::dot(p - middle, second), glm::dot(p - middle, first));
  };
  std::sort(face.begin(), face.end(), [&](const glm::dvec3& a, const glm::dvec3& b) { return angle(a) < angle(b); });
}

std::vector<Face> cut(const std::vector<Face>& faces, const ClipPlane& plane, double same) {
  const double length = glm::length(plane.normal);
  const glm::dvec3 normal = plane.normal / length;
  const auto above = [&](const glm::dvec3& p) { return glm::dot(normal, p) + plane.offset / length; };
  std::vector<Face> out;
  Face hole;
  for (const Face& face : faces) {
    Face kept;
    for (std::size_t i = 0; i < face.size(); ++i) {
      const glm::dvec3 &a = face[i], &b = face[(i + 1) % face.size()];
      const double at_a = above(a), at_b = above(b);
      if (at_a >= -same) addApart(a, same, kept);
      if ((at_a > same && at_b < -same) || (at_a < -same && at_b > same))
        addApart(a + at_a / (at_a - at_b) * (b - a), same, kept);
    }
    for (const glm::dvec3& point : kept) {
      if (std::abs(above(point)) <= 2 * same) addApart(point, 4 * same, hole);
    }
    if (kept.size() >= 3) out.push_back(std::move(kept));
  }
  if (hole.size() >= 3) {
    sortAround(normal, hole);
    out.push_back(std::move(hole));
  }
  return out;
}

// A line as the picture shows it.
struct SeenLine {
  glm::dvec2 a_px, b_px;
  double a_depth, b_depth;
};

std::optional<SeenLine> seen(const WorldLine& line, const View& view, double nearest) {
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

std::vector<WorldLine> edgesOf(const VolumeGeometry& volume, const Clipping& clipping) {
  const auto corners = volume.corners();
  const double same = kSameShare * glm::distance(corners.front(), corners.back());
  std::vector<Face> faces = facesOfBox(volume, clipping);
  for (const ClipPlane& plane : clipping.planes) faces = cut(faces, plane, same);
  std::vector<WorldLine> out;
  for (const Face& face : faces) {
    for (std::size_t i = 0; i < face.size(); ++i) {
      const glm::dvec3 &a = face[i], &b = face[(i + 1) % face.size()];
      const auto near = [&](const glm::dvec3& p, const glm::dvec3& q) { return glm::distance(p, q) <= 8 * same; };
      const auto is_same = [&](const WorldLine& line) {
        return (near(line.first, a) && near(line.second, b)) || (near(line.first, b) && near(line.second, a));
      };
      if (std::none_of(out.begin(), out.end(), is_same)) out.push_back({a, b});
    }
  }
  return out;
}

std::vector<Shape> outlineOfVolume(const AnnotatedPicture& picture, const Style& style) {
  const View& view = picture.view;
  const auto corners = picture.box.corners();
  const double nearest = 1e-4 * glm::distance(corners.front(), corners.back());
  std::vector<Shape> rims, lines;
  for (const WorldLine& edge : edgesOf(picture.box, picture.clipping)) {
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
