#include "scene/stereo.h"

#include <glm/geometric.hpp>

#include "base/error.h"

namespace kiln {

View resolve(const Camera& camera, const std::optional<Stereo>& stereo, const ImageSize& size) {
  View view = resolve(camera, size);
  if (!stereo) return view;
  if (view.projection != Projection::kPerspective)
    throw Error(ErrorCode::kUsage, "--stereo: an orthographic camera sees the same with both eyes; choose perspective");
  const double offset = (stereo->eye == StereoEye::kLeft ? -0.5 : 0.5) * stereo->interocular;
  const double convergence = stereo->convergence.value_or(glm::length(camera.target - camera.eye));
  // A point has its x in view space less by the offset.
  const glm::dvec3 right(view.view_from_world[0][0], view.view_from_world[1][0], view.view_from_world[2][0]);
  view.eye_world += offset * right;
  view.view_from_world[3][0] -= offset;
  view.centre_px.x += offset / convergence * view.focal_px;
  return view;
}

}  // namespace kiln
