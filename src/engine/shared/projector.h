// Projects the lattice into the image: a voxel's centre, the ellipse of its footprint, and a conservative pixel
// rectangle of a box of voxels.
// Invariant. bounds() contains every pixel that a footprint of the box can touch.
// Source: Zwicker et al. 2001 for the footprint of a Gaussian under a projection; Lee and Ihm §2.4 for the projection
// of nodes.
// Differs: low-pass of 0.3 pixel, cut at 3 σ.
#pragma once

#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "grid/geometry.h"
#include "grid/visiting_order.h"
#include "occlusion/visibility.h"
#include "scene/camera/camera.h"
#include "scene/render_options.h"

namespace kiln {

/// Standard deviation of the Gaussian reconstruction kernel: the smallest for which a lattice of equal samples is flat
/// within 1 %. unit: voxel edges.
inline constexpr double kKernelSigma = 0.55;
/// Standard deviation of the Gaussian pixel filter. The filter widens footprints narrower than a pixel, so that each
/// meets a pixel centre. unit: pixels.
inline constexpr double kPixelSigma = 0.3;
/// Radius of a footprint. unit: standard deviations.
inline constexpr double kFootprintRadius = 3.0;

/// Footprint of a voxel: weight exp(-q/2) with q = a dx² + 2 b dx dy + c dy², zero for q > kFootprintRadius².
struct Ellipse {
  float a = 0, b = 0, c = 0;     // unit: 1 / pixel²
  float half_x = 0, half_y = 0;  // half extents of the bounding box. unit: pixels
  float area = 0;                // integral of the weight within the radius. unit: pixels²
};

class Projector {
 public:
  /// Voxels nearer than `near_depth` are not drawn; the default is half the smallest spacing. unit: world.
  Projector(const VolumeGeometry& volume, const View& view, ProjectedArea area = ProjectedArea::kBox,
            std::optional<double> near_depth = std::nullopt);

  bool perspective() const { return perspective_; }
  const VisitingOrder& order() const { return order_; }

  /// Centre of voxel (x, y, z) in view space. Every caller must use this arithmetic: the picture's bits depend on it.
  glm::dvec3 viewOf(const VoxelCoord& v) const {
    return ((origin_ + static_cast<double>(v.z) * axis_z_) + static_cast<double>(v.y) * axis_y_) +
           static_cast<double>(v.x) * axis_x_;
  }
  /// View-space position of a point of index space.
  glm::dvec3 viewOfIndex(const glm::dvec3& index) const {
    return ((origin_ + index.z * axis_z_) + index.y * axis_y_) + index.x * axis_x_;
  }
  /// Direction to the eye from a view-space point, in index space. unit: any length.
  glm::dvec3 towardsEye(const glm::dvec3& view_point) const {
    const glm::dvec3 to_eye = perspective_ ? -view_point : glm::dvec3(0, 0, -1);
    const auto along = [&](int axis) { return glm::dot(glm::dvec3(index_rows_[axis]), to_eye); };
    return {along(0), along(1), along(2)};
  }
  /// Edge of a voxel in view space. requires: 0 <= axis < 3.
  const glm::dvec3& axis(int axis) const { return axis == 0 ? axis_x_ : axis == 1 ? axis_y_ : axis_z_; }
  /// Row that maps a view-space point p to its index coordinate `axis`: dot(row, (p, 1)).
  const glm::dvec4& indexRow(int axis) const { return index_rows_[axis]; }
  /// Perspective: pixels per unit of x/z. Orthographic: pixels per world unit.
  double focal() const { return focal_px_; }
  const glm::dvec2& centre() const { return centre_px_; }
  /// Largest distance of a pixel from the centre along each axis. unit: pixels.
  const glm::dvec2& widest() const { return widest_px_; }
  double voxelVolume() const { return voxel_volume_; }
  /// Covariance of the reconstruction kernel in view space. unit: world².
  const glm::dmat3& covariance() const { return covariance_; }

  /// Nearest depth that is drawn. unit: world, along the view.
  double nearDepth() const { return near_depth_; }

  /// Pixel position of a view-space point. requires: in perspective depth >= nearDepth().
  glm::dvec2 pixelOf(const glm::dvec3& view_point) const {
    const double scale = perspective_ ? focal_px_ / view_point.z : focal_px_;
    return {centre_px_.x + scale * view_point.x, centre_px_.y + scale * view_point.y};
  }
  Ellipse ellipseAt(const glm::dvec3& view_point) const;

  /// Upper bound of the length in pixels of a world length perpendicular to the view anywhere in `box`. Infinite if the
  /// box reaches the eye's plane. unit: `length` in world units, result in pixels.
  double largestPixels(double length, const VoxelBox& box) const;

  /// Inverse transpose that maps a gradient in index space to a normal in view space (not normalised).
  const glm::mat3& viewFromIndexGradient() const { return gradient_; }

  /// Conservative rectangle of the pixels that footprints of voxels of `box` can touch, not clipped to the image. Empty
  /// if no voxel of the box is drawn.
  PixelRect bounds(const VoxelBox& box) const;
  /// Rectangles of eight boxes; undefined for empty boxes. cost: in perspective the time of a single box.
  using Boxes = std::array<VoxelBox, 8>;
  using Rects = std::array<PixelRect, 8>;
  Rects bounds(const Boxes& boxes) const;

 private:
  PixelRect boundsInParallel(const VoxelBox& box) const;
  Rects boundsInPerspective(const Boxes& boxes) const;
  PixelRect boundsOfSphere(const VoxelBox& box) const;
  double longestDiagonal(const glm::dvec3& edges) const;

  ProjectedArea area_;
  bool perspective_;
  glm::dvec3 origin_, axis_x_, axis_y_, axis_z_;
  double focal_px_;
  glm::dvec2 centre_px_, widest_px_;
  double near_depth_;
  double voxel_volume_;
  glm::dvec4 index_rows_[3];
  glm::dmat3 covariance_;  // kernel in view space. unit: world²
  glm::mat3 gradient_;
  VisitingOrder order_;
  Ellipse parallel_ellipse_;
};

}  // namespace kiln
