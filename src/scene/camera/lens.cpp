#include "scene/camera/lens.h"

#include <glm/geometric.hpp>

#include "base/error.h"
#include "grid/spirals.h"

namespace kiln {

View fromMovedEye(View view, const glm::dvec2& offset, double depth) {
  const glm::dmat4& m = view.view_from_world;
  const glm::dvec3 right(m[0][0], m[1][0], m[2][0]), down(m[0][1], m[1][1], m[2][1]);
  view.eye_world += offset.x * right + offset.y * down;
  // Coordinates of all points in view space decrease by the offset.
  view.view_from_world[3][0] -= offset.x;
  view.view_from_world[3][1] -= offset.y;
  view.centre_px += offset / depth * view.focal_px;
  return view;
}

std::vector<View> viewsThrough(const Lens& lens, const View& view, const Camera& camera) {
  std::vector<View> out;
  if (lens.aperture == 0) return out;
  if (view.projection != Projection::kPerspective)
    throw Error(ErrorCode::kUsage, "--aperture: only a perspective camera has a lens; choose perspective");
  const double focus = lens.focus.value_or(glm::dot(camera.target - camera.eye, view.forward_world));
  for (int i = 0; i < lens.eyes; ++i)
    out.push_back(fromMovedEye(view, pointOfDisc(i, lens.eyes, 0.5 * lens.aperture), focus));
  return out;
}

}  // namespace kiln
