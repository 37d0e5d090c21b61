#include "engine/shared/projector.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numbers>
#include <tuple>

#include "base/vectors.h"

namespace kiln {
namespace {

// Margin of rectangles for rounding errors in a footprint's own arithmetic. unit: pixels.
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

// Range of pixels whose centres lie in [v0, v1]; other pixels take no light from a footprint with this extent. floorOf
// replaces std::floor, which is a call without SSE4.1; every tested node needs it.
int floorOf(double v) {
  const int towards_zero = static_cast<int>(v);
  return towards_zero - (v < towards_zero ? 1 : 0);
}
double inRange(double v) { return v < -kFar_px ? -kFar_px : v > kFar_px ? kFar_px : v; }
int firstPixel(double v) { return -floorOf(0.5 - inRange(v)); }
int pixelAfter(double v) { return floorOf(inRange(v) - 0.5) + 1; }
PixelRect rectOf(double x0, double y0, double x1, double y1) {
  return {firstPixel(x0), firstPixel(y0), pixelAfter(x1), pixelAfter(y1)};
}
constexpr PixelRect kEverywhere = {-static_cast<int>(kFar_px), -static_cast<int>(kFar_px), static_cast<int>(kFar_px),
                                   static_cast<int>(kFar_px)};

// Interval of slopes that a ball projects to along one image axis: the two tangents through the eye to the circle of
// `radius` around (x, z). requires: z > radius.
struct Slopes {
  double lo, hi;
};
Slopes tangents(double x, double z, double radius) {
  const double root = radius * std::sqrt(x * x + z * z - radius * radius);
  const double scale = 1 / (z * z - radius * radius);
  return {(x * z - root) * scale, (x * z + root) * scale};
}

// Variance of a footprint along an image axis: s² (C_aa - 2 u C_az + u² C_zz) with s = f/z. The variance is convex in
// the slope u, so its maximum is at an end of the slope interval and at the nearest depth.
struct AxisVariance {
  double own, mixed, depth;  // C_aa, C_az, C_zz
  double at(double u) const { return own + u * (u * depth - 2 * mixed); }
  // Upper bound of the half width of footprints between two slopes. unit: pixels.
  double halfWidth(double s, double u0, double u1) const {
    const double first = at(u0), last = at(u1), most = first > last ? first : last;
    return kFootprintRadius * std::sqrt(s * s * most + kPixelSigma * kPixelSigma) + kRounding;
  }
};

AxisVariance varianceAlong(const glm::dmat3& c, int axis) { return {c[axis][axis], c[2][axis], c[2][2]}; }

// Eight boxes in structure-of-arrays form: each step is a vector operation over all boxes.
constexpr int kBoxes = std::tuple_size_v<Projector::Boxes>;
using Lanes = double[kBoxes];

// Extents of eight boxes of voxels in perspective: slopes x/z and y/z of their corners, widened by a footprint.
struct BoxSpans {
  Lanes lo[2], hi[2];  // unit: pixels from the centre
  Lanes nearest, farthest;
};
struct CornerInput {
  glm::dvec3 origin, axis[3];  // Projector::viewOf
  Lanes first[3], edge[3];     // first voxel; distance from the first to the last voxel
  double focal;
  AxisVariance variance[2];
};
KILN_VECTORS void spanBoxes(const CornerInput& in, BoxSpans& out) noexcept {
  Lanes corner[3][8];  // bit a of the corner's number selects the far end of axis a
  const auto lanes = [](auto f) {
    for (int i = 0; i < kBoxes; ++i) f(i);
  };
  for (int c = 0; c < 3; ++c) {
    lanes([&](int i) {
      corner[c][0][i] = ((in.origin[c] + in.first[2][i] * in.axis[2][c]) + in.first[1][i] * in.axis[1][c]) +
                        in.first[0][i] * in.axis[0][c];
    });
    for (int a = 0; a < 3; ++a) {
      for (int k = 0; k < 1 << a; ++k)
        lanes([&](int i) { corner[c][k | 1 << a][i] = corner[c][k][i] + in.edge[a][i] * in.axis[a][c]; });
    }
  }
  const auto least = [](double a, double b) { return a < b ? a : b; };
  const auto most = [](double a, double b) { return a > b ? a : b; };
  Lanes most_inverse;
  for (int k = 0; k < 8; ++k) {
    Lanes inverse;
    lanes([&](int i) { inverse[i] = 1 / corner[2][k][i]; });
    lanes([&](int i) { most_inverse[i] = k == 0 ? inverse[i] : most(most_inverse[i], inverse[i]); });
    lanes([&](int i) { out.nearest[i] = k == 0 ? corner[2][k][i] : least(out.nearest[i], corner[2][k][i]); });
    lanes([&](int i) { out.farthest[i] = k == 0 ? corner[2][k][i] : most(out.farthest[i], corner[2][k][i]); });
    for (int c = 0; c < 2; ++c) {
      Lanes slope;
      lanes([&](int i) { slope[i] = corner[c][k][i] * inverse[i]; });
      lanes([&](int i) { out.lo[c][i] = k == 0 ? slope[i] : least(out.lo[c][i], slope[i]); });
      lanes([&](int i) { out.hi[c][i] = k == 0 ? slope[i] : most(out.hi[c][i], slope[i]); });
    }
  }
  for (int c = 0; c < 2; ++c) {
    lanes([&](int i) {
      const double half = in.variance[c].halfWidth(in.focal * most_inverse[i], out.lo[c][i], out.hi[c][i]);
      out.lo[c][i] = in.focal * out.lo[c][i] - half;
      out.hi[c][i] = in.focal * out.hi[c][i] + half;
    });
  }
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
  // J C Jᵀ with J = f/z [1 0 -u; 0 1 -v], the derivative of the projection at p.
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
  if (!perspective_) return boundsInParallel(box);
  Boxes boxes;
  boxes.fill(box);
  return boundsInPerspective(boxes).front();
}

Projector::Rects Projector::bounds(const Boxes& boxes) const {
  if (perspective_ && area_ == ProjectedArea::kBox) return boundsInPerspective(boxes);
  Rects out;
  std::transform(boxes.begin(), boxes.end(), out.begin(), [&](const VoxelBox& box) { return bounds(box); });
  return out;
}

double Projector::longestDiagonal(const glm::dvec3& edges) const {
  const glm::dvec3 x = edges.x * axis_x_;
  const glm::dvec3 y = edges.y * axis_y_;
  const glm::dvec3 z = edges.z * axis_z_;
  return std::max({glm::length(x + y + z), glm::length(x + y - z), glm::length(x - y + z), glm::length(x - y - z)});
}

// Bounding rectangle of the sphere through the corners of the node's cube (Lee and Ihm §2.2.3). This sphere need not
// contain the footprints of corner voxels. Therefore a second sphere around the voxel centres is projected and widened
// by a footprint, and the larger rectangle is returned.
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
  if (centre.z - cube < near_depth_) return kEverywhere;
  const auto span = [&](int axis) {
    const Slopes outer = tangents(centre[axis], centre.z, cube);
    const Slopes inner = tangents(centre[axis], centre.z, centres);
    const double kernel =
        varianceAlong(covariance_, axis).halfWidth(focal_px_ * (1 / (centre.z - centres)), inner.lo, inner.hi);
    const double origin = centre_px_[axis];
    return Slopes{origin + std::min(focal_px_ * outer.lo, focal_px_ * inner.lo - kernel),
                  origin + std::max(focal_px_ * outer.hi, focal_px_ * inner.hi + kernel)};
  };
  const Slopes x = span(0);
  const Slopes y = span(1);
  return rectOf(x.lo, y.lo, x.hi, y.hi);
}

// Along each image axis the box's extent is the sum of its projected edges, positive and negative edges separately.
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

// Slopes are undefined for depths of zero or less; boxes that reach in front of the near depth get the whole plane.
Projector::Rects Projector::boundsInPerspective(const Boxes& boxes) const {
  CornerInput in{origin_, {axis_x_, axis_y_, axis_z_}, {}, {}, focal_px_, {}};
  for (int i = 0; i < kBoxes; ++i) {
    const VoxelBox& box = boxes[static_cast<std::size_t>(i)];
    for (int a = 0; a < 3; ++a) {
      in.first[a][i] = static_cast<double>(box.lo[a]);
      in.edge[a][i] = static_cast<double>(box.hi[a] - box.lo[a] - 1);
    }
  }
  for (int c = 0; c < 2; ++c) in.variance[c] = varianceAlong(covariance_, c);
  BoxSpans spans;
  spanBoxes(in, spans);
  Rects out;
  for (int i = 0; i < kBoxes; ++i) {
    PixelRect& rect = out[static_cast<std::size_t>(i)];
    if (spans.farthest[i] < near_depth_)
      rect = {};
    else if (spans.nearest[i] < near_depth_)
      rect = kEverywhere;
    else
      rect = rectOf(centre_px_.x + spans.lo[0][i], centre_px_.y + spans.lo[1][i], centre_px_.x + spans.hi[0][i],
                    centre_px_.y + spans.hi[1][i]);
  }
  return out;
}

}  // namespace kiln
