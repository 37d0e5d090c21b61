// From the lattice to the image: where a voxel's centre falls, how large and how elliptical its footprint is there, and
// what rectangle of pixels everything in a box of voxels can touch. Source: EWA splatting (Zwicker et al. 2001) for the
// footprint of a Gaussian under a projection; Lee and Ihm §2.4 for the projection of nodes.
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

/// The reconstruction kernel is a Gaussian of this standard deviation, in voxels: wide enough that a lattice of equal
/// samples is flat within 1 %, and no wider. unit: voxel edges.
inline constexpr double kKernelSigma = 0.55;
/// A footprint narrower than a pixel is widened by a Gaussian of this standard deviation, so that the pixel lattice
/// catches all of it. unit: pixels.
inline constexpr double kPixelSigma = 0.3;
/// Footprints end at this many standard deviations.
inline constexpr double kFootprintRadius = 3.0;

/// The footprint of one voxel: weight exp(-q/2), q = a dx² + 2 b dx dy + c dy², where q <= kFootprintRadius².
struct Ellipse {
  float a = 0, b = 0, c = 0;     // unit: 1 / pixel²
  float half_x = 0, half_y = 0;  // of its bounding box. unit: pixels
  float area = 0;                // integral of the weight over the plane, cut off at the radius. unit: pixels²
};

class Projector {
 public:
  /// Voxels nearer than `near_depth` are not drawn; half the smallest spacing where it is not given. unit: world.
  Projector(const VolumeGeometry& volume, const View& view, ProjectedArea area = ProjectedArea::kBox,
            std::optional<double> near_depth = std::nullopt);

  bool perspective() const { return perspective_; }
  const VisitingOrder& order() const { return order_; }

  /// The centre of voxel (x,y,z) in view space. The same arithmetic for every caller: the picture depends on it.
  glm::dvec3 viewOf(const VoxelCoord& v) const {
    return ((origin_ + static_cast<double>(v.z) * axis_z_) + static_cast<double>(v.y) * axis_y_) +
           static_cast<double>(v.x) * axis_x_;
  }
  /// Any point of index space in view space.
  glm::dvec3 viewOfIndex(const glm::dvec3& index) const {
    return ((origin_ + index.z * axis_z_) + index.y * axis_y_) + index.x * axis_x_;
  }
  /// A voxel's edge in view space. requires: 0 <= axis < 3.
  const glm::dvec3& axis(int axis) const { return axis == 0 ? axis_x_ : axis == 1 ? axis_y_ : axis_z_; }
  /// Index coordinate `axis` of a view-space point p: dot(row, (p, 1)).
  const glm::dvec4& indexRow(int axis) const { return index_rows_[axis]; }
  /// Perspective: pixels per unit of x/z; else per world unit.
  double focal() const { return focal_px_; }
  const glm::dvec2& centre() const { return centre_px_; }
  /// How far from the centre pixels are, at most. unit: pixels.
  const glm::dvec2& widest() const { return widest_px_; }
  double voxelVolume() const { return voxel_volume_; }
  /// Of the kernel, in view space. unit: world².
  const glm::dmat3& covariance() const { return covariance_; }

  /// unit: world, along the view.
  double nearDepth() const { return near_depth_; }

  /// requires: perspective views have depth >= nearDepth().
  glm::dvec2 pixelOf(const glm::dvec3& view_point) const {
    const double scale = perspective_ ? focal_px_ / view_point.z : focal_px_;
    return {centre_px_.x + scale * view_point.x, centre_px_.y + scale * view_point.y};
  }
  Ellipse ellipseAt(const glm::dvec3& view_point) const;

  /// The most pixels that a world length across the view takes up anywhere in `box`; infinite where the box reaches the
  /// eye's plane. unit: `length` world, the result pixels.
  double largestPixels(double length, const VoxelBox& box) const;

  /// From the gradient in index space to a normal in view space (not normalised): the inverse transpose.
  const glm::mat3& viewFromIndexGradient() const { return gradient_; }

  /// Every pixel that a splat of a voxel of `box` can touch, and perhaps more; not cut off at the image. Empty where no
  /// voxel of the box is drawn.
  PixelRect bounds(const VoxelBox& box) const;
  /// The same of eight boxes, of an empty one anything; in perspective it takes no longer than of one.
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
  glm::dmat3 covariance_;  // of the kernel in view space. unit: world²
  glm::mat3 gradient_;
  VisitingOrder order_;
  Ellipse parallel_ellipse_;
};

}  // namespace kiln
