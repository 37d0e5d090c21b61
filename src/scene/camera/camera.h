// The camera: where the eye is, what it looks at, and how a world point becomes a pixel.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "image/pixel_rect.h"

namespace kiln {

/// kEquirectangular: all directions round the eye, a panorama: from left to right all longitudes, the direction of view
/// in the middle, from top to bottom all latitudes, what is up at the top.
enum class Projection { kPerspective, kOrthographic, kEquirectangular };

/// unit: pixels.
struct ImageSize {
  int width = 1024, height = 1024;
};

/// Of a panorama of which nobody says a size.
inline constexpr ImageSize kPanoramaSize{2048, 1024};

/// The pixels of an image that are drawn: all of them, or `crop`. throws: Error kUsage where the crop is empty or
/// reaches outside of the image.
PixelRect drawnPixels(const ImageSize& size, const std::optional<PixelRect>& crop);

struct Camera {
  Projection projection = Projection::kPerspective;
  glm::dvec3 eye{0, 0, 1}, target{0, 0, 0}, up{0, 1, 0};
  double fov_deg = 60;  // vertical; perspective only
  double height = 1;    // world units the image spans vertically; orthographic only
};

/// A camera resolved for an image. View space has x to the right, y down, z into the scene (depth); the pixel (column,
/// row) covers [column, column+1) × [row, row+1), and row 0 is the top.
struct View {
  Projection projection = Projection::kPerspective;
  ImageSize size;
  glm::dmat4 view_from_world{1.0};
  glm::dvec3 eye_world{0};
  /// A point that the middle of the picture shows: the eye, or in a parallel projection the target, which may be near
  /// the volume where the eye is too far away to compute with.
  glm::dvec3 axis_world{0};
  /// The depth of view space's origin, from the plane through the eye: not 0 of a parallel view that `nearVolume` has
  /// moved. unit: world.
  double origin_depth = 0;
  /// Perspective: pixels per unit of x/z. Orthographic: pixels per world unit. Equirectangular: pixels per radian.
  double focal_px = 1;
  glm::dvec2 centre_px{0};

  /// requires: perspective points have depth > 0; no panorama.
  glm::dvec2 pixelOf(const glm::dvec3& view_point) const {
    const double scale = projection == Projection::kPerspective ? focal_px / view_point.z : focal_px;
    return centre_px + scale * glm::dvec2(view_point);
  }
  /// World direction in which the parallel rays run, or the optical axis. Unit length.
  glm::dvec3 forward_world{0, 0, 1};
};

/// throws: Error kUsage where eye and target coincide, up is along the view, fov, height or size are out of range, or a
/// panorama is not twice as wide as high.
View resolve(const Camera& camera, const ImageSize& size);

/// A parallel view with the origin of view space in front of a volume whose box has this centre and half diagonal: the
/// same pixels, and no rounding that grows with the distance of the eye. Other views are returned as they are.
View nearVolume(View view, const glm::dvec3& centre, double half_diagonal);

/// What the same camera sees in an image `times` as large along each side: pixel (x, y) is then the times² pixels from
/// times (x, y) on. requires: times >= 1.
View enlarged(const View& view, int times);

/// The direction of a panorama's pixel (column, row), in view space; a pixel's centre is half a pixel after its corner.
/// Unit length.
glm::dvec3 panoramaDirection(const View& view, const glm::dvec2& pixel);

/// World to camera as EXR files hold it (camera looks along -z, y up), and to normalised device coordinates in [0,1],
/// y down (RenderMan's screen), third coordinate 1/depth in perspective and depth else. shape: for column vectors, M·p.
glm::dmat4 exrWorldToCamera(const View& view);
glm::dmat4 exrWorldToNdc(const View& view);

}  // namespace kiln
