#include "frame/light/shadow_views.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>

#include "grid/point_bounds.h"
#include "grid/spirals.h"

namespace kiln {
namespace {

// Pixels of a map around the box: bilinear look-ups at the border of the box read them.
constexpr int kMargin_px = 2;
// Largest slope x/z of a single map around a point light; a wider map would waste pixels at its borders.
constexpr double kWidestMap = 1.5;
// Least ratio of the nearest to the farthest depth of a single map around a point light.
constexpr double kNearestShare = 0.05;
// Parts of pixels that are rounding.
constexpr double kRounding_px = 1e-6;
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// A view without size, from `at` along `forward`.
View viewAlong(const glm::dvec3& at, const glm::dvec3& forward) {
  const glm::dvec3 ahead = glm::normalize(forward);
  const glm::dvec3 up = std::abs(ahead.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
  const glm::dvec3 right = glm::normalize(glm::cross(ahead, up)), down = glm::cross(ahead, right);
  const glm::dmat3 axes = glm::transpose(glm::dmat3(right, down, ahead));
  View out;
  out.view_from_world = glm::dmat4(axes);
  out.view_from_world[3] = glm::dvec4(-(axes * at), 1);
  out.eye_world = out.axis_world = at;
  out.forward_world = ahead;
  return out;
}

// Fits the rectangle from `lo` to `hi` of the plane at depth 1 (perspective) or of the view (parallel) into the map.
// Both edges are even or odd as `edge_px` is, so that the middle of the rectangle is always at the same place of a
// pixel: rounding, or an edge that becomes a pixel longer, would move all pixels of a light that turns by half a pixel.
void fit(const glm::dvec2& lo, const glm::dvec2& hi, int edge_px, View& view) {
  const glm::dvec2 extent = hi - lo;
  const int within_px = edge_px - 2 * kMargin_px;
  view.focal_px = within_px / std::max(extent.x, extent.y);
  const auto edgeOf = [&](double length) {
    const int spared = static_cast<int>(0.5 * (within_px - length * view.focal_px) + kRounding_px);
    return edge_px - 2 * std::clamp(spared, 0, (within_px - 1) / 2);
  };
  view.size = {edgeOf(extent.x), edgeOf(extent.y)};
  view.centre_px = 0.5 * glm::dvec2(view.size.width, view.size.height) - 0.5 * view.focal_px * (lo + hi);
}

ShadowView parallelView(const glm::dvec3& towards_light, std::span<const glm::dvec3> points, int edge_px) {
  PointBounds world;
  for (const glm::dvec3& p : points) world.add(p);
  const glm::dvec3 centre = 0.5 * (world.lo + world.hi);
  View view = viewAlong(centre, -towards_light);
  view.projection = Projection::kOrthographic;
  view = nearVolume(view, centre, 0.5 * glm::distance(world.lo, world.hi));
  view.origin_depth = 0;
  PointBounds seen;
  for (const glm::dvec3& p : points) seen.add(glm::dvec3(view.view_from_world * glm::dvec4(p, 1)));
  fit(glm::dvec2(seen.lo), glm::dvec2(seen.hi), edge_px, view);
  const double slack = 1e-3 * (seen.hi.z - seen.lo.z);
  return {view, {seen.lo.z - slack, seen.hi.z + slack}};
}

// A view of all points from the light, if none is beside or behind it.
bool singleView(const glm::dvec3& light, std::span<const glm::dvec3> points, int edge_px, ShadowView& out) {
  glm::dvec3 centre(0);
  for (const glm::dvec3& p : points) centre += p / static_cast<double>(points.size());
  if (!(glm::distance(centre, light) > 0)) return false;
  View view = viewAlong(light, centre - light);
  view.projection = Projection::kPerspective;
  PointBounds slopes;
  double near = kUnbounded, far = 0;
  for (const glm::dvec3& point : points) {
    const glm::dvec3 p(view.view_from_world * glm::dvec4(point, 1));
    if (!(p.z > 0)) return false;
    slopes.add(p / p.z);
    near = std::min(near, p.z), far = std::max(far, p.z);
  }
  const glm::dvec3 widest = glm::max(glm::abs(slopes.lo), glm::abs(slopes.hi));
  if (near < kNearestShare * far || std::max(widest.x, widest.y) > kWidestMap) return false;
  fit(glm::dvec2(slopes.lo), glm::dvec2(slopes.hi), edge_px, view);
  const double slack = 1e-3 * (far - near);
  out = {view, {near - slack, far + slack}};
  return true;
}

std::vector<ShadowView> cubeViews(const glm::dvec3& light, std::span<const glm::dvec3> points, int edge_px) {
  double far = 0;
  for (const glm::dvec3& p : points) far = std::max(far, glm::distance(p, light));
  std::vector<ShadowView> out;
  for (int face = 0; face < 6; ++face) {
    glm::dvec3 forward(0);
    forward[face / 2] = face % 2 == 0 ? 1 : -1;
    View view = viewAlong(light, forward);
    view.projection = Projection::kPerspective;
    fit(glm::dvec2(-1), glm::dvec2(1), edge_px, view);
    out.push_back({view, {0, far}});
  }
  return out;
}

}  // namespace

glm::dvec3 worldDirection(const Light& camera_light, const View& eye) {
  return glm::transpose(glm::dmat3(eye.view_from_world)) * viewDirection(camera_light);
}

Light standing(Light light, const View& eye) {
  if (light.kind != LightKind::kCamera) return light;
  light.place = worldDirection(light, eye);
  light.kind = LightKind::kDirectional;
  return light;
}

std::vector<Light> pointsOf(const Light& soft, const View& eye, const glm::dvec3& centre) {
  const Light light = standing(soft, eye);
  if (!(light.shadow.softness > 0)) return {light};
  const bool far = light.kind == LightKind::kDirectional;
  const glm::dvec3 towards = far ? glm::normalize(light.place) : light.place - centre;
  const double radius = glm::length(towards) * std::tan(glm::radians(0.5 * light.shadow.softness));
  const glm::dmat3 axes = glm::transpose(glm::dmat3(viewAlong(centre, towards).view_from_world));
  std::vector<Light> out;
  for (int i = 0; i < kSoftLights; ++i) {
    const glm::dvec2 moved = pointOfDisc(i, kSoftLights, radius);
    out.push_back(light);
    out.back().place += moved.x * axes[0] + moved.y * axes[1];
    if (far) out.back().place = towards + (out.back().place - light.place);
  }
  return out;
}

std::vector<ShadowView> shadowViews(const Light& light, std::span<const glm::dvec3> points, int edge_px) {
  if (light.kind == LightKind::kDirectional) return {parallelView(light.place, points, edge_px)};
  ShadowView single;
  if (singleView(light.place, points, edge_px, single)) return {single};
  return cubeViews(light.place, points, edge_px);
}

double pixelEdge(const ShadowView& view) {
  const bool perspective = view.view.projection == Projection::kPerspective;
  return (perspective ? view.depths.far : 1) / view.view.focal_px;
}

}  // namespace kiln
