#include "splat/projector.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numbers>

#include "base/vectors.h"

namespace kiln {
namespace {

// Rectangles are widened by this, so that rounding in a footprint's own arithmetic never leaves them. unit: pixels.
constexpr double kRounding = 0.01;

Ellipse ellipseOf(double xx, double xy, double yy) {
  xx += kPixelSigma * kPixelSigma;
  yy += kPixelSigma * kPixelSigma;
  const double determinant = xx * yy - xy * xy;
  const double cut = kFootprintRadius * kFootprintRadius;
  Ellipse out;
  out.a = static_cast<float>(yy / determinant);
  out.b = static_cast<float>(-xy / determinant);
  out.c = static_cast<float>(xx / determinant);
  out.half_x = static_cast<float>(kFootprintRadius * std::sqrt(xx));
  out.half_y = static_cast<float>(kFootprintRadius * std::sqrt(yy));
  out.area = static_cast<float>(2 * std::numbers::pi * std::sqrt(determinant) * -std::expm1(-cut / 2));
  return out;
}

VisitingOrder orderOf(const VolumeGeometry& volume, const View& view) {
  const glm::dmat4 index_from_world = glm::inverse(volume.world_from_index);
  const glm::dvec3 spacing = volume.spacing();
  if (view.projection == Projection::kPerspective) {
    return VisitingOrder::fromEye(glm::dvec3(index_from_world * glm::dvec4(view.eye_world, 1.0)), spacing);
  }
  return VisitingOrder::parallel(glm::dvec3(index_from_world * glm::dvec4(view.forward_world, 0.0)), spacing);
}

// The pixels whose centres lie in [x0, x1] by [y0, y1]: no other takes light from a footprint in there. Every node asks
// for it, and without SSE4.1 std::floor is a call.
PixelRect rectOf(double x0, double y0, double x1, double y1) {
  const auto floor = [](double v) {
    const int towards_zero = static_cast<int>(v);
    return towards_zero - (v < towards_zero ? 1 : 0);
  };
  const auto first = [&](double v) { return -floor(0.5 - std::clamp(v, -kFar_px, kFar_px)); };
  const auto last = [&](double v) { return floor(std::clamp(v, -kFar_px, kFar_px) - 0.5); };
  return {first(x0), first(y0), last(x1) + 1, last(y1) + 1};
}

// What a ball's projection spans along one axis of the image, as slopes: the two tangents through the eye to a circle
// of `radius` around (x, z). requires: z > radius.
struct Slopes {
  double lo, hi;
};
Slopes tangents(double x, double z, double radius) {
  const double root = radius * std::sqrt(x * x + z * z - radius * radius);
  const double scale = 1 / (z * z - radius * radius);
  return {(x * z - root) * scale, (x * z + root) * scale};
}

// What the corners of a box span: slopes x/z and y/z, depths and their reciprocals.
struct CornerSpan {
  Slopes x, y;
  double nearest, farthest, most_inverse;
};
// From one corner by three edges. Every node asks for it: eight corners are two vectors, and a division each. Slopes
// say nothing where a depth is not above zero.
KILN_VECTORS CornerSpan spanOfCorners(const glm::dvec3& first, const glm::dvec3* edges) noexcept {
  double x[8] = {first.x}, y[8] = {first.y}, z[8] = {first.z};
  for (int edge = 0, known = 1; edge < 3; ++edge, known *= 2) {
    for (int i = 0; i < known; ++i) x[known + i] = x[i] + edges[edge].x;
    for (int i = 0; i < known; ++i) y[known + i] = y[i] + edges[edge].y;
    for (int i = 0; i < known; ++i) z[known + i] = z[i] + edges[edge].z;
  }
  double inverse[8];
  for (int i = 0; i < 8; ++i) inverse[i] = 1 / z[i];
  for (int i = 0; i < 8; ++i) x[i] *= inverse[i];
  for (int i = 0; i < 8; ++i) y[i] *= inverse[i];
  const auto first_of = [](const double* v, auto before) {
    double four[4];
    for (int i = 0; i < 4; ++i) four[i] = before(v[i], v[4 + i]) ? v[i] : v[4 + i];
    return std::min(std::min(four[0], four[1], before), std::min(four[2], four[3], before), before);
  };
  const auto least = [&](const double* v) { return first_of(v, std::less<>()); };
  const auto most = [&](const double* v) { return first_of(v, std::greater<>()); };
  return {{least(x), most(x)}, {least(y), most(y)}, least(z), most(z), most(inverse)};
}

}  // namespace

Projector::Projector(const VolumeGeometry& volume, const View& view, ProjectedArea area,
                     std::optional<double> near_depth)
    : area_(area),
      perspective_(view.projection == Projection::kPerspective),
      focal_px_(view.focal_px),
      centre_px_(view.centre_px),
      widest_px_(glm::max(view.centre_px, glm::dvec2(view.size.width, view.size.height) - view.centre_px)),
      voxel_volume_(volume.voxelVolume()),
      order_(orderOf(volume, view)) {
  const glm::dmat4 view_from_index = view.view_from_world * volume.world_from_index;
  axis_x_ = glm::dvec3(view_from_index[0]);
  axis_y_ = glm::dvec3(view_from_index[1]);
  axis_z_ = glm::dvec3(view_from_index[2]);
  origin_ = glm::dvec3(view_from_index[3]);
  const glm::dmat4 index_from_view = glm::transpose(glm::inverse(view_from_index));
  for (int axis = 0; axis < 3; ++axis) index_rows_[axis] = index_from_view[axis];
  near_depth_ = near_depth.value_or(0.5 * volume.shortestEdge());
  const glm::dmat3 linear(view_from_index);
  covariance_ = kKernelSigma * kKernelSigma * (linear * glm::transpose(linear));
  gradient_ = glm::mat3(glm::transpose(glm::inverse(linear)));
  const double s = focal_px_ * focal_px_;
  parallel_ellipse_ = ellipseOf(s * covariance_[0][0], s * covariance_[1][0], s * covariance_[1][1]);
}

Ellipse Projector::ellipseAt(const glm::dvec3& p) const {
  if (!perspective_) return parallel_ellipse_;
  // J C Jᵀ with J = f/z [1 0 -u; 0 1 -v], the projection's derivative at p.
  const double s = focal_px_ / p.z * (focal_px_ / p.z);
  const double u = p.x / p.z;
  const double v = p.y / p.z;
  const glm::dmat3& c = covariance_;
  return ellipseOf(s * (c[0][0] - 2 * u * c[2][0] + u * u * c[2][2]),
                   s * (c[1][0] - v * c[2][0] - u * c[2][1] + u * v * c[2][2]),
                   s * (c[1][1] - 2 * v * c[2][1] + v * v * c[2][2]));
}

double Projector::largestPixels(double length, const VoxelBox& box) const {
  if (!perspective_) return length * focal_px_;
  const auto nearest = [](double axis, std::int64_t lo, std::int64_t hi) {
    return std::min(axis * (static_cast<double>(lo) - 0.5), axis * (static_cast<double>(hi) - 0.5));
  };
  const double depth = origin_.z + nearest(axis_x_.z, box.lo.x, box.hi.x) + nearest(axis_y_.z, box.lo.y, box.hi.y) +
                       nearest(axis_z_.z, box.lo.z, box.hi.z);
  return depth > 0 ? length * focal_px_ / depth : std::numeric_limits<double>::infinity();
}

PixelRect Projector::bounds(const VoxelBox& box) const {
  if (area_ == ProjectedArea::kSphere) return boundsOfSphere(box);
  return perspective_ ? boundsInPerspective(box) : boundsInParallel(box);
}

double Projector::longestDiagonal(const glm::dvec3& edges) const {
  const glm::dvec3 x = edges.x * axis_x_;
  const glm::dvec3 y = edges.y * axis_y_;
  const glm::dvec3 z = edges.z * axis_z_;
  return std::max({glm::length(x + y + z), glm::length(x + y - z), glm::length(x - y + z), glm::length(x - y - z)});
}

// The footprint's variance along an image axis is s² (C_aa - 2 u C_az + u² C_zz), s = f/z: convex in the slope u, so
// largest at an end of its interval, and largest at the nearest depth.
double Projector::largestHalfWidth(int axis, double most_inverse, double u0, double u1) const {
  const glm::dmat3& c = covariance_;
  const auto variance = [&](double u) { return c[axis][axis] + u * (u * c[2][2] - 2 * c[2][axis]); };
  const double s = focal_px_ * most_inverse;
  return kFootprintRadius * std::sqrt(s * s * std::max(variance(u0), variance(u1)) + kPixelSigma * kPixelSigma) +
         kRounding;
}

// Lee and Ihm §2.2.3: the box around the projection of the sphere through the corners of the node's cube. That sphere
// need not hold the footprints of voxels at the corners, so a second one is taken around the voxels' centres, its
// rectangle is widened by a footprint, and the larger of the two counts: the answer is conservative.
PixelRect Projector::boundsOfSphere(const VoxelBox& box) const {
  const glm::dvec3 edges(box.extent().x, box.extent().y, box.extent().z);
  const glm::dvec3 centre = 0.5 * (viewOf(box.lo) + viewOf({box.hi.x - 1, box.hi.y - 1, box.hi.z - 1}));
  const double cube = 0.5 * longestDiagonal(edges);
  const double centres = 0.5 * longestDiagonal(edges - 1.0);
  if (!perspective_) {
    const double rx = std::max(cube * focal_px_, centres * focal_px_ + parallel_ellipse_.half_x + kRounding);
    const double ry = std::max(cube * focal_px_, centres * focal_px_ + parallel_ellipse_.half_y + kRounding);
    const glm::dvec2 at = pixelOf(centre);
    return rectOf(at.x - rx, at.y - ry, at.x + rx, at.y + ry);
  }
  if (centre.z + centres < near_depth_) return {};
  if (centre.z - cube < near_depth_) return rectOf(-kFar_px, -kFar_px, kFar_px, kFar_px);
  const auto span = [&](int axis) {
    const Slopes outer = tangents(centre[axis], centre.z, cube);
    const Slopes inner = tangents(centre[axis], centre.z, centres);
    const double kernel = largestHalfWidth(axis, 1 / (centre.z - centres), inner.lo, inner.hi);
    const double origin = centre_px_[axis];
    return Slopes{origin + std::min(focal_px_ * outer.lo, focal_px_ * inner.lo - kernel),
                  origin + std::max(focal_px_ * outer.hi, focal_px_ * inner.hi + kernel)};
  };
  const Slopes x = span(0);
  const Slopes y = span(1);
  return rectOf(x.lo, y.lo, x.hi, y.hi);
}

// Along each axis of the image, edges of the box that go its way lead from the least to the greatest.
PixelRect Projector::boundsInParallel(const VoxelBox& box) const {
  glm::dvec2 lo(viewOf(box.lo)), hi = lo;
  const auto reach = [&](const glm::dvec3& axis, std::int64_t voxels) {
    const glm::dvec2 edge = static_cast<double>(voxels - 1) * glm::dvec2(axis);
    lo += glm::min(edge, 0.0);
    hi += glm::max(edge, 0.0);
  };
  const Extent3 extent = box.extent();
  reach(axis_x_, extent.x), reach(axis_y_, extent.y), reach(axis_z_, extent.z);
  const glm::dvec2 half(parallel_ellipse_.half_x + kRounding, parallel_ellipse_.half_y + kRounding);
  lo = centre_px_ + focal_px_ * lo - half;
  hi = centre_px_ + focal_px_ * hi + half;
  return rectOf(lo.x, lo.y, hi.x, hi.y);
}

PixelRect Projector::boundsInPerspective(const VoxelBox& box) const {
  const Extent3 extent = box.extent();
  const glm::dvec3 edges[3] = {static_cast<double>(extent.x - 1) * axis_x_, static_cast<double>(extent.y - 1) * axis_y_,
                               static_cast<double>(extent.z - 1) * axis_z_};
  const CornerSpan span = spanOfCorners(viewOf(box.lo), edges);
  if (span.farthest < near_depth_) return {};
  if (span.nearest < near_depth_) return rectOf(-kFar_px, -kFar_px, kFar_px, kFar_px);
  const double rx = largestHalfWidth(0, span.most_inverse, span.x.lo, span.x.hi);
  const double ry = largestHalfWidth(1, span.most_inverse, span.y.lo, span.y.hi);
  return rectOf(centre_px_.x + focal_px_ * span.x.lo - rx, centre_px_.y + focal_px_ * span.y.lo - ry,
                centre_px_.x + focal_px_ * span.x.hi + rx, centre_px_.y + focal_px_ * span.y.hi + ry);
}

}  // namespace kiln
