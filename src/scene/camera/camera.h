// The camera: eye, target, and the projection of world points to pixels.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "image/pixel_rect.h"

namespace kiln {

/// kEquirectangular is a panorama: all longitudes from left to right, with the view direction in the middle, and all
/// latitudes from top (up) to bottom.
enum class Projection { kPerspective, kOrthographic, kEquirectangular };

/// unit: pixels.
struct ImageSize {
  int width = 1024, height = 1024;
  bool operator==(const ImageSize&) const = default;
};

/// Default size of a panorama.
inline constexpr ImageSize kPanoramaSize{2048, 1024};

/// Returns the pixels to draw: `crop`, or the whole image. throws: Error kUsage if the crop is empty or extends outside
/// the image.
PixelRect drawnPixels(const ImageSize& size, const std::optional<PixelRect>& crop);

struct Camera {
  Projection projection = Projection::kPerspective;
  glm::dvec3 eye{0, 0, 1}, target{0, 0, 0}, up{0, 1, 0};
  double fov_deg = 60;  // vertical; perspective only
  double height = 1;    // world units the image spans vertically; orthographic only
};

/// A camera resolved for an image. View space has x to the right, y down, z into the scene (depth). The pixel (column,
/// row) covers [column, column+1) × [row, row+1); row 0 is the top.
struct View {
  Projection projection = Projection::kPerspective;
  ImageSize size;
  glm::dmat4 view_from_world{1.0};
  glm::dvec3 eye_world{0};
  /// A point shown in the middle of the picture: the eye; in a parallel projection the target, which may be near the
  /// volume while the eye is too far away for exact arithmetic.
  glm::dvec3 axis_world{0};
  /// Depth of view space's origin, from the plane through the eye; not 0 for parallel views moved by `nearVolume`.
  /// unit: world.
  double origin_depth = 0;
  /// Perspective: pixels per unit of x/z. Orthographic: pixels per world unit. Equirectangular: pixels per radian.
  double focal_px = 1;
  glm::dvec2 centre_px{0};

  /// requires: perspective points have depth > 0; no panorama.
  glm::dvec2 pixelOf(const glm::dvec3& view_point) const {
    const double scale = projection == Projection::kPerspective ? focal_px / view_point.z : focal_px;
    return centre_px + scale * glm::dvec2(view_point);
  }
  /// World direction of the parallel rays, or the optical axis. Unit length.
  glm::dvec3 forward_world{0, 0, 1};
};

/// throws: Error kUsage if eye and target coincide, up is along the view, fov, height or size is out of range, or a
/// panorama is not twice as wide as high.
View resolve(const Camera& camera, const ImageSize& size);

/// Moves the origin of a parallel view in front of a volume whose box has this centre and half diagonal: pixels are
/// unchanged, and rounding no longer grows with the distance of the eye. Other views are returned unchanged.
View nearVolume(View view, const glm::dvec3& centre, double half_diagonal);

/// Returns the view for an image `times` as large along each side: pixel (x, y) becomes the times² pixels from
/// times·(x, y) on. requires: times >= 1.
View enlarged(const View& view, int times);

/// Returns the direction of a panorama's pixel (column, row) in view space; a pixel's centre is half a pixel after its
/// corner. Unit length.
glm::dvec3 panoramaDirection(const View& view, const glm::dvec2& pixel);

/// Matrices in EXR's convention. World to camera: the camera looks along -z, y up. World to normalised device
/// coordinates: in [0,1], y down (RenderMan's screen); the third coordinate is 1/depth in perspective, else depth.
/// shape: for column vectors, M·p.
glm::dmat4 exrWorldToCamera(const View& view);
glm::dmat4 exrWorldToNdc(const View& view);

}  // namespace kiln
