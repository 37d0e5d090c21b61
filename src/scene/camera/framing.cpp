// Fits exactly, not by a bounding sphere. The points of the outline, and the turned points of a turntable, are
// transformed to the camera's axes.
// Each point requires a least distance (perspective) or height (orthographic) to be inside the image; the greatest
// decides. The margin is applied in the image, so it is equal for every field of view. Free edges of the picture make
// the image smaller; a pan then moves the image to its place, and changes no size.
#include "scene/camera/framing.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <limits>

#include "base/error.h"

namespace kiln {
namespace {

struct Direction {
  glm::dvec3 towards_eye, up;
};

Direction directionOf(PatientFrame frame, Side side) {
  const PatientAxes axes = patientAxes(frame);
  switch (side) {
    case Side::kFront:
      return {axes.anterior, axes.superior};
    case Side::kBack:
      return {-axes.anterior, axes.superior};
    case Side::kLeft:
      return {axes.left, axes.superior};
    case Side::kRight:
      return {-axes.left, axes.superior};
    case Side::kTop:
      return {axes.superior, axes.anterior};
    case Side::kBottom:
      return {-axes.superior, axes.anterior};
  }
  return {};
}

Direction directionOf(PatientFrame frame, const Framing& framing) {
  const Direction seen = directionOf(frame, framing.side);
  // To the right in the picture: from the front, the patient's left.
  const glm::dvec3 right = glm::cross(seen.up, seen.towards_eye);
  const double azimuth = glm::radians(framing.azimuth_deg);
  const double elevation = glm::radians(framing.elevation_deg);
  const glm::dvec3 level = std::cos(azimuth) * seen.towards_eye + std::sin(azimuth) * right;
  Direction turned{std::cos(elevation) * level + std::sin(elevation) * seen.up, seen.up};
  // From straight above or below, the up axis is the line of sight. The limit of the turned pictures gives the up
  // direction instead.
  if (std::abs(framing.elevation_deg) > 89.99) turned.up = framing.elevation_deg > 0 ? -level : level;
  return turned;
}

// Half the rectangle's extent at depth 1 in x and y, without the margin.
glm::dvec2 usableTangents(double fov_deg, double margin, const ImageSize& size, const glm::dvec2& rectangle) {
  const double tangent = std::tan(0.5 * glm::radians(fov_deg)) / margin;
  return {tangent * rectangle.x / size.height, tangent * (rectangle.y / size.height)};
}

// Calls each(point) for the points of the outline, turned and not turned, in the camera's axes, relative to the target.
template <class Each>
void forPointsSeen(const FramedBox& box, const Camera& camera, const ImageSize& size, const Turns& turns, Each&& each) {
  const glm::dmat3 seen(resolve(camera, size).view_from_world);
  const glm::dvec3 centre = centreOf(box.volume), moved = seen * (centre - camera.target);
  for (const glm::dvec3& point : box.outline) each(seen * (point - camera.target));
  for (const glm::dmat3& turn : turns.rotations) {
    const glm::dmat3 turned = seen * turn;
    for (const glm::dvec3& point : box.outline) each(moved + turned * (point - centre));
  }
}

// At distance d, a point at p has the depth d + p.z, and |p.x - shift| <= tangent · depth must hold. Hence
// d >= p.x / tangent - p.z - shift / tangent and d >= -p.x / tangent - p.z + shift / tangent. A pan moves the eye by
// -d · aside, and |p.x - shift + d · aside - depth · aside| = |p.x - p.z · aside - shift| <= tangent · depth must hold:
// the points are sheared.
struct Perspective {
  glm::dvec2 tangents, aside;
  glm::dvec2 sheared(const glm::dvec3& point) const { return glm::dvec2(point) - point.z * aside; }
};

// The greatest right sides, without shift, of the points of both signs.
struct Reach {
  glm::dvec2 above{-INFINITY}, below{-INFINITY};
};

Reach reachSeen(const FramedBox& box, const Camera& camera, const ImageSize& size, const Turns& turns,
                const Perspective& seen) {
  Reach out;
  forPointsSeen(box, camera, size, turns, [&](const glm::dvec3& point) {
    const glm::dvec2 slope = seen.sheared(point) / seen.tangents;
    out.above = glm::max(out.above, slope - point.z), out.below = glm::max(out.below, -slope - point.z);
  });
  return out;
}

// The distance of an eye that sees the outline, and the shift of eye and target to the middle of what is seen, along
// the camera's x and y.
struct Place {
  double distance = 0;
  glm::dvec2 shift{0};
};

// The shift that makes both right sides equal.
glm::dvec2 middleOf(const Reach& reach, const Perspective& seen) {
  return 0.5 * seen.tangents * (reach.above - reach.below);
}

// With the shift to the middle, the least distance is the mean of the greatest right sides.
Place fittingPlace(const Reach& reach, const Perspective& seen, bool centred) {
  if (centred) {
    const glm::dvec2 least = 0.5 * (reach.above + reach.below);
    return {std::max(least.x, least.y), middleOf(reach, seen)};
  }
  const glm::dvec2 least = glm::max(reach.above, reach.below);
  return {std::max(least.x, least.y), glm::dvec2(0)};
}

// The least and the greatest x and y of the outline in the camera's axes, around the target.
struct Span {
  glm::dvec2 lo{INFINITY}, hi{-INFINITY};
};

// The camera with its axes, for where its height is not known yet.
Camera withAxesOnly(Camera camera) {
  camera.projection = Projection::kPerspective;
  camera.fov_deg = 90;
  return camera;
}

// The rows are right, down and along the view, in the world.
glm::dmat3 axesOf(const Camera& camera, const ImageSize& size) {
  return glm::dmat3(resolve(withAxesOnly(camera), size).view_from_world);
}

Span spanSeen(const FramedBox& box, const Camera& camera, const ImageSize& size, const Turns& turns) {
  Span out;
  forPointsSeen(box, withAxesOnly(camera), size, turns, [&](const glm::dvec3& point) {
    out.lo = glm::min(out.lo, glm::dvec2(point)), out.hi = glm::max(out.hi, glm::dvec2(point));
  });
  return out;
}

// Moves the target along the axis of the turns by the part of `middle`, along the camera's x and y, that lies along the
// axis as the camera sees it. All points move alike, so that the middle moves by the same amount. The target stays
// within the outline, also where the axis is almost along the view.
Camera movedAlongAxis(const FramedBox& box, const Camera& camera, const Turns& turns, const glm::dvec2& axis_seen,
                      const glm::dvec2& middle) {
  const int along = std::abs(axis_seen.x) > std::abs(axis_seen.y) ? 0 : 1;
  if (std::abs(axis_seen[along]) < 1e-6) return camera;
  double lo = 0, hi = 0;
  for (const glm::dvec3& point : box.outline) {
    const double place = glm::dot(point - camera.target, turns.axis);
    lo = std::min(lo, place), hi = std::max(hi, place);
  }
  const glm::dvec3 by = std::clamp(middle[along] / axis_seen[along], lo, hi) * turns.axis;
  Camera out = camera;
  out.eye += by;
  out.target += by;
  return out;
}

double heightAround(const glm::dvec2& half, double margin, const ImageSize& size, const glm::dvec2& rectangle) {
  return 2 * std::max(half.y / (rectangle.y / size.height), half.x * size.height / rectangle.x) * margin;
}

Camera shifted(const Camera& camera, const glm::dvec2& by, const ImageSize& size) {
  if (by == glm::dvec2(0)) return camera;
  const glm::dmat3 axes = glm::transpose(axesOf(camera, size));
  Camera out = camera;
  out.eye += by.x * axes[0] + by.y * axes[1];
  out.target += by.x * axes[0] + by.y * axes[1];
  return out;
}

void requireLegal(const Framing& framing) {
  const auto refuse = [](const char* sentence) { throw Error(ErrorCode::kUsage, sentence); };
  requireZoom(framing.zoom);
  if (!std::isfinite(framing.roll_deg)) refuse("camera: roll must be a finite number of degrees");
  if (!std::isfinite(framing.azimuth_deg)) refuse("camera: azimuth must be a finite number of degrees");
  if (!(std::abs(framing.elevation_deg) <= 90)) refuse("camera: elevation must be from -90 to 90 degrees");
  if (!(framing.fov_deg > 0 && framing.fov_deg < 180)) {
    refuse("camera: the field of view must be between 0 and 180 degrees");
  }
}

}  // namespace

glm::dvec2 FreeEdges::rectangle(const ImageSize& size) const {
  return {size.width - left - right, size.height - top - bottom};
}

glm::dvec2 FreeEdges::shift(const ImageSize& size) const {
  return {0.5 * (left - right) / size.width, 0.5 * (bottom - top) / size.height};
}

glm::dvec3 towardsEye(PatientFrame frame, Side side) { return directionOf(frame, side).towards_eye; }

FramedBox::FramedBox(VolumeGeometry box, Fit how) : volume(std::move(box)), fit(how) {
  const auto corners = volume.corners();
  outline.assign(corners.begin(), corners.end());
}

Framing defaultFraming() {
  Framing framing;
  framing.azimuth_deg = 30;
  framing.elevation_deg = 15;
  return framing;
}

// Corners are relative to the first volume's origin: for origins far from zero (map coordinates) only the rounding of
// the origins themselves remains, and none for a single volume.
VolumeGeometry boxAround(const std::vector<VolumeGeometry>& volumes) {
  VolumeGeometry out = volumes.front();
  const glm::dmat3 index_from_world = glm::inverse(glm::dmat3(out.world_from_index));
  const glm::dvec3 origin(out.world_from_index[3]);
  glm::dvec3 lo(-0.5), hi = glm::dvec3(out.dims.x, out.dims.y, out.dims.z) - 0.5;
  double farthest = 0;
  for (VolumeGeometry volume : volumes) {
    const glm::dvec3 own_origin(volume.world_from_index[3]);
    for (int axis = 0; axis < 3; ++axis)
      farthest = std::max({farthest, std::abs(own_origin[axis]), std::abs(origin[axis])});
    volume.world_from_index[3] = glm::dvec4(own_origin - origin, 1);
    for (const glm::dvec3& corner : volume.corners()) {
      const glm::dvec3 index = index_from_world * corner;
      lo = glm::min(lo, index);
      hi = glm::max(hi, index);
    }
  }
  // Tolerance for rounding: a billionth of a voxel, and the last digits of the origins.
  const double rounding = 1e-9 + 8 * std::numeric_limits<double>::epsilon() * farthest / out.shortestEdge();
  const glm::dvec3 first = glm::floor(lo + 0.5 + rounding), end = glm::ceil(hi + 0.5 - rounding);
  const glm::dvec3 size = end - first;
  out.dims = {static_cast<std::int64_t>(size.x), static_cast<std::int64_t>(size.y), static_cast<std::int64_t>(size.z)};
  out.world_from_index[3] = out.world_from_index * glm::dvec4(first, 1);
  return out;
}

VolumeGeometry partOf(const VolumeGeometry& volume, const VoxelBox& box) {
  VolumeGeometry out = volume;
  out.dims = box.extent();
  const glm::dvec3 first(box.lo.x, box.lo.y, box.lo.z);
  out.world_from_index[3] = volume.world_from_index * glm::dvec4(first, 1);
  return out;
}

glm::dvec3 centreOf(const VolumeGeometry& volume) {
  return volume.worldOf(0.5 * glm::dvec3(volume.dims.x - 1, volume.dims.y - 1, volume.dims.z - 1));
}

double fittingHeight(const FramedBox& box, const Camera& camera, const ImageSize& size) {
  const Span span = spanSeen(box, camera, size, {});
  return heightAround(glm::max(span.hi, -span.lo), box.margin(), size, FreeEdges().rectangle(size));
}

void requireZoom(double zoom) {
  if (!(zoom > 0) || !std::isfinite(zoom)) throw Error(ErrorCode::kUsage, "camera: zoom must be a number above 0");
}

Camera turned(Camera camera, const glm::dvec3& axis, double angle) {
  if (angle == 0) return camera;
  const glm::dquat turn = glm::angleAxis(angle, glm::normalize(axis));
  camera.eye = camera.target + turn * (camera.eye - camera.target);
  camera.up = turn * camera.up;
  return camera;
}

Camera rolled(const Camera& camera, double degrees) {
  if (degrees == 0) return camera;
  const glm::dquat turn = glm::angleAxis(glm::radians(degrees), glm::normalize(camera.target - camera.eye));
  Camera out = camera;
  out.up = turn * camera.up;
  return out;
}

Camera panned(const Camera& camera, const glm::dvec2& pan, const ImageSize& size) {
  if (pan == glm::dvec2(0)) return camera;
  const bool parallel = camera.projection == Projection::kOrthographic;
  const double height =
      parallel ? camera.height
               : 2 * std::tan(0.5 * glm::radians(camera.fov_deg)) * glm::distance(camera.eye, camera.target);
  // Rows of the rotation: right, down and along the view, in the world.
  const glm::dmat3 axes = glm::transpose(glm::dmat3(resolve(camera, size).view_from_world));
  const glm::dvec3 by = height * (pan.y * axes[1] - pan.x * size.width / size.height * axes[0]);
  Camera out = camera;
  out.eye += by;
  out.target += by;
  return out;
}

Camera frameVolume(const FramedBox& box, const Framing& framing, const ImageSize& size, const Turns& turns,
                   const FreeEdges& edges) {
  requireLegal(framing);
  const glm::dvec2 rectangle = edges.rectangle(size);
  const VolumeGeometry& volume = box.volume;
  const Direction seen = directionOf(volume.frame, framing);
  const glm::dvec3 centre = centreOf(volume);
  double radius = 0;
  for (const glm::dvec3& point : box.outline) radius = std::max(radius, glm::distance(point, centre));

  Camera camera;
  camera.projection = framing.projection;
  camera.fov_deg = framing.fov_deg;
  camera.target = centre;
  camera.up = framing.up.value_or(seen.up);
  // A parallel view is equal from everywhere along its axis; two radii keep the whole outline in front of the eye.
  camera.eye = centre + 2 * radius * seen.towards_eye;
  camera = rolled(camera, framing.roll_deg);
  const bool along_axis = box.isCentredAlongAxis(turns);
  const glm::dvec3 axis = along_axis ? axesOf(camera, size) * turns.axis : glm::dvec3(0);
  if (framing.projection == Projection::kOrthographic) {
    Span span = spanSeen(box, camera, size, turns);
    if (along_axis) {
      camera = movedAlongAxis(box, camera, turns, axis, 0.5 * (span.lo + span.hi));
      span = spanSeen(box, camera, size, turns);
    }
    const glm::dvec2 middle = box.isCentred(turns) ? 0.5 * (span.lo + span.hi) : glm::dvec2(0);
    const glm::dvec2 half = glm::max(span.hi - middle, middle - span.lo);
    camera.height = heightAround(half, box.margin(), size, rectangle) / framing.zoom;
    return shifted(camera, middle, size);
  }
  const glm::dvec2 tangents = usableTangents(framing.fov_deg, box.margin(), size, rectangle);
  // The slope of the ray through the middle of the rectangle, right and down.
  const double across = 2 * std::tan(0.5 * glm::radians(framing.fov_deg)) / framing.zoom;
  const glm::dvec2 shift = edges.shift(size), aside = across * glm::dvec2(shift.x * size.width / size.height, -shift.y);
  const Perspective perspective{tangents, aside};
  Reach reach = reachSeen(box, camera, size, turns, perspective);
  if (along_axis) {
    camera = movedAlongAxis(box, camera, turns, perspective.sheared(axis), middleOf(reach, perspective));
    reach = reachSeen(box, camera, size, turns, perspective);
  }
  const Place place = fittingPlace(reach, perspective, box.isCentred(turns));
  camera.eye = camera.target + place.distance * seen.towards_eye;
  camera = shifted(camera, place.shift, size);
  camera.fov_deg = glm::degrees(2 * std::atan(std::tan(0.5 * glm::radians(framing.fov_deg)) / framing.zoom));
  return camera;
}

}  // namespace kiln
