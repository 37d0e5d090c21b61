// The camera: an orthonormal frame at the eye (x right, y down, z along the view) and a focal length in pixels. Both
// EXR matrices are the same frame in the axes that other programs expect. Matrices multiply column vectors.
#include "scene/camera/camera.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/trigonometric.hpp>
#include <string>

#include "base/error.h"

namespace kiln {
namespace {

bool finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

Error refused(const std::string& sentence) { return Error(ErrorCode::kUsage, "camera: " + sentence); }

void requireSize(const ImageSize& size) {
  const auto legal = [](int side) { return side >= 1 && side <= kLargestSide_px; };
  if (legal(size.width) && legal(size.height)) return;
  throw Error(ErrorCode::kUsage, fmt::format("an image of {}x{} pixels cannot be drawn; each side must be from 1 to {}",
                                             size.width, size.height, kLargestSide_px));
}

double focalOf(const Camera& camera, const ImageSize& size) {
  double focal_px = 0;
  if (camera.projection == Projection::kEquirectangular) {
    if (size.width != 2 * size.height)
      throw Error(ErrorCode::kUsage,
                  fmt::format("an equirectangular image of {}x{} pixels: it shows 360 by 180 degrees, "
                              "so it is twice as wide as high, such as 2048x1024",
                              size.width, size.height));
    focal_px = size.height / glm::pi<double>();
  } else if (camera.projection == Projection::kPerspective) {
    if (!(camera.fov_deg > 0 && camera.fov_deg < 180)) {
      throw refused("the field of view must be between 0 and 180 degrees, but is " + std::to_string(camera.fov_deg));
    }
    focal_px = 0.5 * size.height / std::tan(0.5 * glm::radians(camera.fov_deg));
  } else {
    if (!(camera.height > 0)) {
      throw refused("the orthographic height must be above 0, but is " + std::to_string(camera.height));
    }
    focal_px = size.height / camera.height;
  }
  if (!(focal_px > 0) || !std::isfinite(focal_px)) {
    throw refused("the field of view or height is too extreme to compute with");
  }
  return focal_px;
}

}  // namespace

PixelRect drawnPixels(const ImageSize& size, const std::optional<PixelRect>& crop) {
  const PixelRect all{0, 0, size.width, size.height};
  if (!crop) return all;
  if (!crop->empty() && intersection(*crop, all) == *crop) return *crop;
  throw Error(ErrorCode::kUsage,
              fmt::format("--crop: expected at least one pixel, and none outside of the picture of {} x {} pixels "
                          "(found {},{},{},{})",
                          size.width, size.height, crop->x0, crop->y0, crop->width(), crop->height()));
}

View resolve(const Camera& camera, const ImageSize& size) {
  requireSize(size);
  if (!finite(camera.eye) || !finite(camera.target) || !finite(camera.up)) {
    throw refused("eye, target and up must be finite numbers");
  }
  const double distance = glm::length(camera.target - camera.eye);
  if (!(distance > 0)) throw refused("eye and target are the same point, so there is no direction to look in");
  const double up_length = glm::length(camera.up);
  const auto found = [&] { return fmt::format(" (found {:g}, {:g}, {:g})", camera.up.x, camera.up.y, camera.up.z); };
  if (!(up_length > 0)) throw refused("up is the zero vector" + found() + "; give a direction");
  if (!std::isfinite(distance + up_length)) throw refused("eye, target or up is too large to compute with");
  const glm::dvec3 forward = (camera.target - camera.eye) / distance;
  const glm::dvec3 across = glm::cross(forward, camera.up / up_length);
  // The sine of the angle between up and the view; below a millionth the roll of the picture would be rounding noise.
  if (glm::length(across) < 1e-6) throw refused("up runs along the line of sight" + found() + "; give another up");

  View view;
  view.projection = camera.projection;
  view.size = size;
  view.focal_px = focalOf(camera, size);
  view.centre_px = 0.5 * glm::dvec2(size.width, size.height);
  view.eye_world = camera.eye;
  view.forward_world = forward;
  view.axis_world = camera.projection == Projection::kOrthographic ? camera.target : camera.eye;
  const glm::dvec3 right = glm::normalize(across);
  const glm::dvec3 rows[] = {right, glm::cross(forward, right), forward};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) view.view_from_world[column][row] = rows[row][column];
    view.view_from_world[3][row] = -glm::dot(rows[row], camera.eye);
  }
  return view;
}

glm::dvec3 panoramaDirection(const View& view, const glm::dvec2& pixel) {
  const glm::dvec2 angle = (pixel - view.centre_px) / view.focal_px;
  return {std::sin(angle.x) * std::cos(angle.y), std::sin(angle.y), std::cos(angle.x) * std::cos(angle.y)};
}

View nearVolume(View view, const glm::dvec3& centre, double half_diagonal) {
  if (view.projection != Projection::kOrthographic) return view;
  const glm::dmat3 axes(view.view_from_world);
  const glm::dvec3 across = axes * (centre - view.axis_world);
  const glm::dvec3 translation = glm::dvec3(across.x, across.y, half_diagonal) - axes * centre;
  view.origin_depth += (axes * (centre - view.eye_world)).z - half_diagonal;
  view.view_from_world[3] = glm::dvec4(translation, 1);
  view.eye_world = centre - half_diagonal * view.forward_world;
  return view;
}

View enlarged(const View& view, int times) {
  View out = view;
  out.size = {times * view.size.width, times * view.size.height};
  out.focal_px *= times;
  out.centre_px *= times;
  return out;
}

glm::dmat4 exrWorldToCamera(const View& view) {
  glm::dmat4 camera_from_view(1.0);
  camera_from_view[1][1] = -1;
  camera_from_view[2][2] = -1;
  return camera_from_view * view.view_from_world;
}

glm::dmat4 exrWorldToNdc(const View& view) {
  const glm::dvec2 scale = view.focal_px / glm::dvec2(view.size.width, view.size.height);
  const glm::dvec2 centre = view.centre_px / glm::dvec2(view.size.width, view.size.height);
  glm::dmat4 ndc_from_view(1.0);
  ndc_from_view[0][0] = scale.x;
  ndc_from_view[1][1] = scale.y;
  if (view.projection == Projection::kOrthographic) {
    ndc_from_view[3][0] = centre.x;
    ndc_from_view[3][1] = centre.y;
  } else {
    // (x, y, z, 1) becomes (scale x + centre z, …, 1, z). After division the third coordinate is 1/depth, so the matrix
    // is invertible without clipping planes, which a splatter does not have.
    ndc_from_view[2] = glm::dvec4(centre, 0, 1);
    ndc_from_view[3] = glm::dvec4(0, 0, 1, 0);
  }
  return ndc_from_view * view.view_from_world;
}

}  // namespace kiln
