// Solids by their signed distance: rounded cones (including balls, ellipsoids and capsules), boxes and cylinders with
// rounded edges.
// Method. A description in millimetres (`ShapeSpec`) is converted once to plain numbers (`Shape`) for the kernels.
// Invariant. Only sums, products, quotients and square roots of floats: every machine computes equal bits.
// Source: I. Quilez, "Distance functions" and "Smooth minimum".
// Differs: the distance of a rounded cone is the minimum over the balls along its axis, without branches. The distance
// of a shape stretched by an affine map is the mapped distance divided by the length of its gradient: exact on the
// surface, first order beside it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>

namespace kiln::phantom {

enum class ShapeKind : std::uint8_t { kCone, kStretchedCone, kBox, kCylinder };

/// Description of a solid. unit: mm.
struct ShapeSpec {
  ShapeKind kind = ShapeKind::kCone;
  glm::dvec3 a{0}, b{0};              // centres of a cone's end balls; equal for other solids
  double radius_a = 0, radius_b = 0;  // radii of a cone's end balls; for a box or cylinder radius_a rounds the edges
  glm::dvec3 half{0};          // semi-axes of an ellipsoid; half edges of a box; (radius, -, half length) of a cylinder
  glm::dvec3 axis{0, 0, 1};    // local z, unless a and b give it
  glm::dvec3 across{0, 1, 0};  // local y, made perpendicular to z
  double thickness = 1;        // extent of a cone along `across`, relative to its radius
  double blend_mm = 0;         // distance at which the solid begins to flow into earlier solids of its part
  double shell_mm = 0;         // depth below the surface at which the part's inner tissue begins
  bool carves = false;         // subtracts instead of adding

  ShapeSpec blend(double mm) const;
  ShapeSpec shell(double mm) const;
  ShapeSpec carve() const;
  /// Scales along `direction`, for ribs, blades, palms.
  ShapeSpec flat(const glm::dvec3& direction, double factor) const;
  /// Rotates the solid so that local z and y lie along the arguments.
  ShapeSpec turned(const glm::dvec3& z, const glm::dvec3& y = {0, 1, 0}) const;
  /// Mirrors at the plane x = 0.
  ShapeSpec mirrored() const;
};

ShapeSpec ball(const glm::dvec3& centre, double radius);
ShapeSpec cone(const glm::dvec3& a, const glm::dvec3& b, double radius_a, double radius_b);
ShapeSpec ellipsoid(const glm::dvec3& centre, const glm::dvec3& semi_axes);
ShapeSpec box(const glm::dvec3& centre, const glm::dvec3& half_edges, double rounding);
ShapeSpec cylinder(const glm::dvec3& a, const glm::dvec3& b, double radius, double rounding = 0);

/// Numbers for the kernels. unit: mm, except in the local space of a stretched cone.
struct Shape {
  float row[3][4];              // local coordinates of p are row · (p, 1)
  float radius, cosine, slope;  // ball at 0; radii shrink by `cosine` per length; `slope` = cosine / sine
  float length;                 // length of the axis
  float stretch[3];             // local lengths per millimetre along each local axis
  float tiny;                   // keeps the quotient of a stretched cone finite at its centre
  float half[3];                // minus rounding; box: half edges; cylinder: radius, -, half length
  float centre[3], extent[3];   // bounding box: centre and half edges
  float blend, shell;
  ShapeKind kind;
  bool carves;
};

Shape prepared(const ShapeSpec& spec);

/// Returns the signed distance of the point, negative inside. unit: mm.
template <ShapeKind kKind>
inline float distance(const Shape& s, float x, float y, float z) {
  // Terms of y and z first, because they are constant in a row of voxels.
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
    // The distance to the ball at t along the axis is √(ρ² + (w-t)²) - radius(t); its minimum is at (w-t)/ρ = slope.
    const float rho2 = u * u + v * v;
    const float t = std::min(std::max(w - std::sqrt(rho2) * s.slope, 0.f), s.length);
    const float rise = w - t;
    const float from_axis = std::sqrt(rho2 + rise * rise);
    const float local = from_axis - s.radius + s.cosine * t;
    if constexpr (kKind == ShapeKind::kCone) return local;
    const float gu = u * s.stretch[0], gv = v * s.stretch[1], gw = rise * s.stretch[2];
    const float gradient = std::sqrt(gu * gu + gv * gv + gw * gw);
    const float first_order = local * ((from_axis + s.tiny) / (gradient + s.tiny));
    // Far away the first order may be too small; the distance to the bounding box never exceeds the true distance.
    const float bx = std::abs(x - s.centre[0]) - s.extent[0], by = std::abs(y - s.centre[1]) - s.extent[1];
    const float bz = std::abs(z - s.centre[2]) - s.extent[2];
    return std::max(first_order, std::max(bx, std::max(by, bz)));
  }
}

/// As `distance`, for a kind known only at run time.
float distanceTo(const Shape& shape, float x, float y, float z);

/// The minimum of two distances, rounded where they differ by less than `blend`, else exactly the minimum.
inline float smoothMin(float a, float b, float blend, float inverse_blend) {
  const float overlap = std::max(blend - std::abs(a - b), 0.f);
  return std::min(a, b) - 0.25f * overlap * overlap * inverse_blend;
}

/// Returns the distance to a union `before` after adding or carving `shape`, at distance `d`, for the surface at
/// `depth` below.
inline float joined(const Shape& shape, float before, float d, float depth) {
  const float inverse = shape.blend > 0 ? 1 / shape.blend : 0.f;
  if (shape.carves) return -smoothMin(-before, d - depth, shape.blend, inverse);
  return smoothMin(before, d + depth, shape.blend, inverse);
}

}  // namespace kiln::phantom
