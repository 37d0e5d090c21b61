#include "bench/views.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace kiln {
namespace {

Camera cameraOf(const Suite& suite, const SuiteCase& c, const VolumeGeometry& volume, const ImageSize& size,
                Projection projection) {
  CameraSpec spec = c.camera;
  spec.projection = projection;
  spec.fov_deg = spec.fov_deg.value_or(suite.fov_deg);
  double zoom = 1;
  if (!spec.eye && spec.zoom) {
    zoom = *spec.zoom;
    spec.zoom = 1;
  }
  Camera camera = spec.resolve(volume, size);
  camera.eye = camera.target + (camera.eye - camera.target) / (projection == Projection::kPerspective ? zoom : 1);
  if (!spec.height) camera.height /= zoom;
  return camera;
}

// Rotates the eye about the axis `up` through the target by Rodrigues' formula.
Camera turned(Camera camera, double turn_deg) {
  const glm::dvec3 axis = glm::normalize(camera.up);
  const glm::dvec3 arm = camera.eye - camera.target;
  const double angle = glm::radians(turn_deg);
  const glm::dvec3 along = glm::dot(axis, arm) * axis;
  camera.eye = camera.target + along + std::cos(angle) * (arm - along) + std::sin(angle) * glm::cross(axis, arm);
  return camera;
}

}  // namespace

std::vector<SuiteView> suiteViews(const Suite& suite, const SuiteCase& c, const VolumeGeometry& volume,
                                  const ImageSize& size, Projection projection) {
  const Camera camera = cameraOf(suite, c, volume, size, projection);
  std::vector<SuiteView> out;
  for (int i = 0; i < suite.views; ++i) {
    const double step = suite.views > 1 ? suite.turn_deg / (suite.views - 1) : 0;
    const double turn_deg = suite.views > 1 ? i * step - suite.turn_deg / 2 : 0;
    out.push_back({turn_deg, resolve(turned(camera, turn_deg), size)});
  }
  return out;
}

}  // namespace kiln
