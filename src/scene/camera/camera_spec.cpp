// Completes the user's camera settings: an eye, or a framing, with defaults for missing values.
#include "scene/camera/camera_spec.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <span>
#include <string>

#include "base/error.h"

namespace kiln {
namespace {

void refuseContradictions(const CameraSpec& spec) {
  const auto refuse = [](const std::string& sentence) { throw Error(ErrorCode::kUsage, "camera: " + sentence); };
  if (spec.height && !spec.projection) {
    refuse("height is of an orthographic camera; give projection orthographic too, or fov instead");
  }
  if (spec.projection == Projection::kEquirectangular) {
    const char* const of_others = spec.fov_deg  ? "fov"
                                  : spec.height ? "height"
                                  : spec.zoom   ? "zoom"
                                  : spec.pan    ? "pan"
                                                : nullptr;
    if (of_others)
      refuse(std::string(of_others) + " is not of an equirectangular camera, which sees all round; leave it out");
  }
  if (!spec.eye) return;
  if (spec.side) refuse("eye and view contradict each other; give one of them");
  if (spec.projection == Projection::kEquirectangular && (spec.azimuth_deg || spec.elevation_deg))
    refuse(
        "azimuth and elevation turn an eye about its target, and an equirectangular camera stays at its eye; "
        "give another target");
}

// Turns the eye about the target, as a framing is turned. requires: eye and target differ.
Camera turnedAsFraming(const Camera& camera, double azimuth_deg, double elevation_deg) {
  const Camera level = turned(camera, camera.up, glm::radians(azimuth_deg));
  const glm::dvec3 away = level.eye - level.target, aside = glm::cross(away, glm::normalize(level.up));
  // From straight above or below, no elevation is a turn towards `up`.
  if (glm::length(aside) <= 1e-9 * glm::length(away)) return level;
  return turned(level, aside, glm::radians(elevation_deg));
}

void enlarge(Camera& camera, double zoom) {
  requireZoom(zoom);
  if (camera.projection == Projection::kOrthographic)
    camera.height /= zoom;
  else
    camera.fov_deg = glm::degrees(2 * std::atan(std::tan(0.5 * glm::radians(camera.fov_deg)) / zoom));
}

Camera fromEye(const CameraSpec& spec, const FramedBox& box, const ImageSize& size) {
  const VolumeGeometry& volume = box.volume;
  Camera camera;
  camera.projection = spec.projection.value_or(Projection::kPerspective);
  camera.eye = *spec.eye;
  camera.target = spec.target.value_or(centreOf(volume));
  camera.fov_deg = spec.fov_deg.value_or(camera.fov_deg);
  const PatientAxes axes = patientAxes(volume.frame);
  camera.up = spec.up.value_or(axes.superior);
  const glm::dvec3 along = camera.target - camera.eye;
  if (!spec.up && glm::length(glm::cross(along, camera.up)) <= 1e-6 * glm::length(along)) camera.up = axes.anterior;
  camera = turnedAsFraming(camera, spec.azimuth_deg.value_or(0), spec.elevation_deg.value_or(0));
  camera = rolled(camera, spec.roll_deg.value_or(0));
  if (camera.projection == Projection::kOrthographic) {
    camera.height = spec.height ? *spec.height : fittingHeight(box, camera, size);
  }
  if (spec.zoom) enlarge(camera, *spec.zoom);
  return camera;
}

Camera fromFraming(const CameraSpec& spec, const FramedBox& box, const ImageSize& size, const Turns& turns,
                   const FreeEdges& edges) {
  const bool turned = spec.side || spec.azimuth_deg || spec.elevation_deg;
  Framing framing = turned ? Framing{} : defaultFraming();
  framing.side = spec.side.value_or(framing.side);
  framing.azimuth_deg = spec.azimuth_deg.value_or(framing.azimuth_deg);
  framing.elevation_deg = spec.elevation_deg.value_or(framing.elevation_deg);
  framing.up = spec.up;
  framing.roll_deg = spec.roll_deg.value_or(framing.roll_deg);
  framing.zoom = spec.zoom.value_or(framing.zoom);
  framing.projection = spec.projection.value_or(framing.projection);
  framing.fov_deg = spec.fov_deg.value_or(framing.fov_deg);
  const bool panorama = framing.projection == Projection::kEquirectangular;
  if (panorama) framing.projection = Projection::kPerspective;
  Camera camera = frameVolume(box, framing, size, turns, edges);
  if (panorama) {
    // A panorama is taken from the middle of the volume, with the volume all around.
    camera.projection = Projection::kEquirectangular;
    const glm::dvec3 ahead = camera.target - camera.eye;
    camera.eye = centreOf(box.volume);
    camera.target = camera.eye + ahead;
  }
  if (spec.target && panorama) {
    const glm::dvec3 upright = rolled(camera, -framing.roll_deg).up;
    camera.target = *spec.target;
    camera.up = upright;
    camera = rolled(camera, framing.roll_deg);
  } else if (spec.target) {
    camera.eye += *spec.target - camera.target;
    camera.target = *spec.target;
  }
  if (camera.projection == Projection::kOrthographic) camera.height = spec.height.value_or(camera.height);
  return camera;
}

// Greater for a smaller picture of the box.
double distanceOf(const Camera& camera) {
  return camera.projection == Projection::kOrthographic ? camera.height : glm::distance(camera.eye, camera.target);
}

// Takes the edges that leave the largest picture, the first of equal ones.
UnpannedCamera besideEdges(const CameraSpec& spec, const FramedBox& box, const ImageSize& size, const Turns& turns) {
  const FreeEdges none;
  const std::span choices = box.free_edges.empty() ? std::span(&none, 1) : std::span(box.free_edges);
  UnpannedCamera out{fromFraming(spec, box, size, turns, choices.front()), choices.front().shift(size)};
  for (const FreeEdges& edges : choices.subspan(1)) {
    const Camera camera = fromFraming(spec, box, size, turns, edges);
    if (distanceOf(camera) < distanceOf(out.camera)) out = {camera, edges.shift(size)};
  }
  return out;
}

}  // namespace

UnpannedCamera CameraSpec::unpanned(const FramedBox& box, const ImageSize& size, const Turns& turns) const {
  refuseContradictions(*this);
  UnpannedCamera out;
  if (eye)
    out.camera = fromEye(*this, box, size);
  else if (leavesEdges())
    out = besideEdges(*this, box, size, turns);
  else
    out.camera = fromFraming(*this, box, size, turns, {});
  if (pan) out.pan += *pan;
  kiln::resolve(out.camera, size);  // refuses an unusable camera before long work
  return out;
}

Camera CameraSpec::resolve(const FramedBox& box, const ImageSize& size, const Turns& turns) const {
  const UnpannedCamera out = unpanned(box, size, turns);
  return panned(out.camera, out.pan, size);
}

}  // namespace kiln
