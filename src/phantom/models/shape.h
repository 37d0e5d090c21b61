// The solids that figures are made of, each by its signed distance: rounded cones (balls, ellipsoids and capsules among
// them), boxes and cylinders with rounded edges. A description (`ShapeSpec`, in millimetres, what the anatomy is
// written in) is prepared once into plain numbers (`Shape`, what the kernels read).
// Only sums, products, quotients and square roots of floats: every machine gives the same bits.
// Source: I. Quilez, "Distance functions" and "Smooth minimum". Departs from them for rounded cones, whose distance is
// written as the least over the balls along the axis, without branches; and for shapes stretched by an affine map,
// whose distance is the mapped one divided by the length of its gradient: exact on the surface and to first order
// beside it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>

namespace kiln::phantom {

enum class ShapeKind : std::uint8_t { kCone, kStretchedCone, kBox, kCylinder };

/// A solid as people describe it. unit: mm.
struct ShapeSpec {
  ShapeKind kind = ShapeKind::kCone;
  glm::dvec3 a{0}, b{0};              // the centres of a cone's balls; of another solid the centre, twice
  double radius_a = 0, radius_b = 0;  // of a cone; of a box or cylinder radius_a rounds the edges
  glm::dvec3 half{0};          // an ellipsoid's semi-axes, a box's half edges; a cylinder's (radius, -, half length)
  glm::dvec3 axis{0, 0, 1};    // the local z, where a and b do not give it
  glm::dvec3 across{0, 1, 0};  // the local y, made perpendicular to z
  double thickness = 1;        // a cone's extent along `across`, of its radius
  double blend_mm = 0;         // how far before a solid of the same part it begins to flow into it
  double shell_mm = 0;         // how far below the surface the part's inner tissue begins
  bool carves = false;         // takes away instead of adding

  ShapeSpec blend(double mm) const;
  ShapeSpec shell(double mm) const;
  ShapeSpec carve() const;
  /// Thinner or thicker along `direction`: a rib, a blade, a palm.
  ShapeSpec flat(const glm::dvec3& direction, double factor) const;
  /// Turned so that the local z and y lie along these.
  ShapeSpec turned(const glm::dvec3& z, const glm::dvec3& y = {0, 1, 0}) const;
  /// On the other side of the plane x = 0.
  ShapeSpec mirrored() const;
};

ShapeSpec ball(const glm::dvec3& centre, double radius);
ShapeSpec cone(const glm::dvec3& a, const glm::dvec3& b, double radius_a, double radius_b);
ShapeSpec ellipsoid(const glm::dvec3& centre, const glm::dvec3& semi_axes);
ShapeSpec box(const glm::dvec3& centre, const glm::dvec3& half_edges, double rounding);
ShapeSpec cylinder(const glm::dvec3& a, const glm::dvec3& b, double radius, double rounding = 0);

/// A solid as the kernels read it. unit: mm, but for the local space of a stretched cone.
struct Shape {
  float row[3][4];              // the local coordinates of p are row · (p, 1)
  float radius, cosine, slope;  // of the ball at 0; radii shrink by `cosine` a length; `slope` = cosine / sine
  float length;                 // of the axis
  float stretch[3];             // local lengths a millimetre along each local axis
  float tiny;                   // keeps the quotient of a stretched cone finite at its middle
  float half[3];                // box: half edges less rounding; cylinder: radius, -, half length, less rounding
  float centre[3], extent[3];   // the box around it: middle and half edges
  float blend, shell;
  ShapeKind kind;
  bool carves;
};

Shape prepared(const ShapeSpec& spec);

/// The signed distance of the point, negative inside. unit: mm.
template <ShapeKind kKind>
inline float distance(const Shape& s, float x, float y, float z) {
  // The terms of y and z first: they are the same for a row of voxels.
  const float u = s.row[0][0] * x + (s.row[0][1] * y + (s.row[0][2] * z + s.row[0][3]));
  const float v = s.row[1][0] * x + (s.row[1][1] * y + (s.row[1][2] * z + s.row[1][3]));
  const float w = s.row[2][0] * x + (s.row[2][1] * y + (s.row[2][2] * z + s.row[2][3]));
  if constexpr (kKind == ShapeKind::kBox) {
    const float a = std::abs(u) - s.half[0], b = std::abs(v) - s.half[1], c = std::abs(w) - s.half[2];
    const float ap = std::max(a, 0.f), bp = std::max(b, 0.f), cp = std::max(c, 0.f);
    return std::sqrt(ap * ap + bp * bp + cp * cp) + std::min(std::max(a, std::max(b, c)), 0.f) - s.radius;
  } else if constexpr (kKind == ShapeKind::kCylinder) {
    const float a = std::sqrt(u * u + v * v) - s.half[0], c = std::abs(w) - s.half[2];
    const float ap = std::max(a, 0.f), cp = std::max(c, 0.f);
    return std::sqrt(ap * ap + cp * cp) + std::min(std::max(a, c), 0.f) - s.radius;
  } else {
    // The distance to the ball at t along the axis is √(ρ² + (w-t)²) - radius(t), least where (w-t)/ρ = slope.
    const float rho2 = u * u + v * v;
    const float t = std::min(std::max(w - std::sqrt(rho2) * s.slope, 0.f), s.length);
    const float rise = w - t;
    const float from_axis = std::sqrt(rho2 + rise * rise);
    const float local = from_axis - s.radius + s.cosine * t;
    if constexpr (kKind == ShapeKind::kCone) return local;
    const float gu = u * s.stretch[0], gv = v * s.stretch[1], gw = rise * s.stretch[2];
    const float gradient = std::sqrt(gu * gu + gv * gv + gw * gw);
    const float first_order = local * ((from_axis + s.tiny) / (gradient + s.tiny));
    // Far away the first order can be too near; the box around the shape is never too far.
    const float bx = std::abs(x - s.centre[0]) - s.extent[0], by = std::abs(y - s.centre[1]) - s.extent[1];
    const float bz = std::abs(z - s.centre[2]) - s.extent[2];
    return std::max(first_order, std::max(bx, std::max(by, bz)));
  }
}

/// The same where the kind is not known beforehand.
float distanceTo(const Shape& shape, float x, float y, float z);

/// The least of two distances, rounded where they differ by less than `blend`; elsewhere exactly the least.
inline float smoothMin(float a, float b, float blend, float inverse_blend) {
  const float overlap = std::max(blend - std::abs(a - b), 0.f);
  return std::min(a, b) - 0.25f * overlap * overlap * inverse_blend;
}

/// The distance to what was there (`before`) after `shape`, at distance `d`, is added or carved, at `depth` below its
/// surface.
inline float joined(const Shape& shape, float before, float d, float depth) {
  const float inverse = shape.blend > 0 ? 1 / shape.blend : 0.f;
  if (shape.carves) return -smoothMin(-before, d - depth, shape.blend, inverse);
  return smoothMin(before, d + depth, shape.blend, inverse);
}

}  // namespace kiln::phantom
