// Fits exactly, not by a bounding sphere. The points of the outline, and the turned points of a turntable, are
// transformed to the camera's axes.
// Each point requires a least distance (perspective) or height (orthographic) to be inside the image; the greatest
// decides. The margin is applied in the image, so it is equal for every field of view.
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

Direction directionOf(PatientFrame frame, const Framing& framing) {
  const PatientAxes axes = patientAxes(frame);
  Direction seen{axes.anterior, axes.superior};
  switch (framing.side) {
    case Side::kFront:
      break;
    case Side::kBack:
      seen = {-axes.anterior, axes.superior};
      break;
    case Side::kLeft:
      seen = {axes.left, axes.superior};
      break;
    case Side::kRight:
      seen = {-axes.left, axes.superior};
      break;
    case Side::kTop:
      seen = {axes.superior, axes.anterior};
      break;
    case Side::kBottom:
      seen = {-axes.superior, axes.anterior};
      break;
  }
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

// Half the image's extent at depth 1 in x and y, without the margin.
glm::dvec2 usableTangents(double fov_deg, double margin, const ImageSize& size) {
  const double tangent = std::tan(0.5 * glm::radians(fov_deg)) / margin;
  return {tangent * size.width / size.height, tangent};
}

// Calls each(point) for the points of the outline, turned and not turned, in the camera's axes, relative to the target.
template <class Each>
void forPointsSeen(const FramedBox& box, const Camera& camera, const ImageSize& size, Turns turns, Each&& each) {
  const glm::dmat3 seen(resolve(camera, size).view_from_world);
  const glm::dvec3 centre = centreOf(box.volume), moved = seen * (centre - camera.target);
  for (const glm::dvec3& point : box.outline) each(seen * (point - camera.target));
  for (const glm::dmat3& turn : turns) {
    const glm::dmat3 turned = seen * turn;
    for (const glm::dvec3& point : box.outline) each(moved + turned * (point - centre));
  }
}

double fittingDistance(const FramedBox& box, const Camera& camera, const ImageSize& size, Turns turns) {
  const glm::dvec2 tangents = usableTangents(camera.fov_deg, box.margin(), size);
  double distance = 0;
  forPointsSeen(box, camera, size, turns, [&](const glm::dvec3& offset) {
    // At distance d the point's depth is d + offset.z, and |offset.x| <= tangent · depth must hold.
    distance = std::max(distance, std::abs(offset.x) / tangents.x - offset.z);
    distance = std::max(distance, std::abs(offset.y) / tangents.y - offset.z);
  });
  return distance;
}

void requireLegal(const Framing& framing) {
  const auto refuse = [](const char* sentence) { throw Error(ErrorCode::kUsage, sentence); };
  if (!(framing.zoom > 0) || !std::isfinite(framing.zoom)) refuse("camera: zoom must be a number above 0");
  if (!std::isfinite(framing.roll_deg)) refuse("camera: roll must be a finite number of degrees");
  if (!std::isfinite(framing.azimuth_deg)) refuse("camera: azimuth must be a finite number of degrees");
  if (!(std::abs(framing.elevation_deg) <= 90)) refuse("camera: elevation must be from -90 to 90 degrees");
  if (!(framing.fov_deg > 0 && framing.fov_deg < 180)) {
    refuse("camera: the field of view must be between 0 and 180 degrees");
  }
}

}  // namespace

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

double fittingHeight(const FramedBox& box, const Camera& camera, const ImageSize& size, Turns turns) {
  Camera plain = camera;
  plain.projection = Projection::kPerspective;  // only the axes are needed, and the height is not known yet
  plain.fov_deg = 90;
  double half = 0;
  forPointsSeen(box, plain, size, turns, [&](const glm::dvec3& offset) {
    half = std::max({half, std::abs(offset.y), std::abs(offset.x) * size.height / size.width});
  });
  return 2 * half * box.margin();
}

Camera rolled(const Camera& camera, double degrees) {
  if (degrees == 0) return camera;
  const glm::dquat turn = glm::angleAxis(glm::radians(degrees), glm::normalize(camera.target - camera.eye));
  Camera out = camera;
  out.up = turn * camera.up;
  return out;
}

Camera panned(const Camera& camera, const glm::dvec2& pan, const ImageSize& size) {
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

Camera frameVolume(const FramedBox& box, const Framing& framing, const ImageSize& size, Turns turns) {
  requireLegal(framing);
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
  if (framing.projection == Projection::kOrthographic) {
    camera.height = fittingHeight(box, camera, size, turns) / framing.zoom;
    return camera;
  }
  camera.eye = centre + fittingDistance(box, camera, size, turns) * seen.towards_eye;
  camera.fov_deg = glm::degrees(2 * std::atan(std::tan(0.5 * glm::radians(framing.fov_deg)) / framing.zoom));
  return camera;
}

}  // namespace kiln
