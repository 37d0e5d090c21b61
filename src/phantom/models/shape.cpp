#include "phantom/models/shape.h"

#include <glm/geometric.hpp>

namespace kiln::phantom {
namespace {

// Local axes as rows: z along `axis`, y as close to `across` as possible.
struct Axes {
  glm::dvec3 x, y, z;
};

Axes axesOf(const glm::dvec3& axis, const glm::dvec3& across) {
  Axes out;
  out.z = glm::normalize(axis);
  glm::dvec3 side = across - glm::dot(across, out.z) * out.z;
  if (glm::dot(side, side) < 1e-6) {
    const glm::dvec3 other = std::abs(out.z.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1);
    side = other - glm::dot(other, out.z) * out.z;
  }
  out.y = glm::normalize(side);
  out.x = glm::cross(out.y, out.z);
  return out;
}

bool isEllipsoid(const ShapeSpec& spec) { return spec.kind == ShapeKind::kStretchedCone && spec.half.x > 0; }

glm::dvec3 mirroredX(const glm::dvec3& v) { return {-v.x, v.y, v.z}; }

void setRows(Shape& shape, const Axes& axes, const glm::dvec3& scale, const glm::dvec3& origin) {
  const glm::dvec3 rows[3] = {axes.x * scale.x, axes.y * scale.y, axes.z * scale.z};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) shape.row[i][j] = static_cast<float>(rows[i][j]);
    shape.row[i][3] = static_cast<float>(-glm::dot(rows[i], origin));
    shape.stretch[i] = static_cast<float>(scale[i]);
  }
}

// Sets the bounding box of two ellipsoids (or boxes) with these half axes, at a and b.
void setBounds(Shape& shape, const ShapeSpec& spec, const Axes& axes, const glm::dvec3& half_a,
               const glm::dvec3& half_b, bool corners) {
  for (int i = 0; i < 3; ++i) {
    const auto reach = [&](const glm::dvec3& half) {
      const double u = std::abs(axes.x[i] * half.x), v = std::abs(axes.y[i] * half.y), w = std::abs(axes.z[i] * half.z);
      return corners ? u + v + w : std::sqrt(u * u + v * v + w * w);
    };
    const double lo = std::min(spec.a[i] - reach(half_a), spec.b[i] - reach(half_b));
    const double hi = std::max(spec.a[i] + reach(half_a), spec.b[i] + reach(half_b));
    shape.centre[i] = static_cast<float>(0.5 * (lo + hi));
    shape.extent[i] = static_cast<float>(0.5 * (hi - lo));
  }
}

void prepareCone(Shape& shape, const ShapeSpec& spec) {
  if (isEllipsoid(spec)) {
    const Axes axes = axesOf(spec.axis, spec.across);
    setRows(shape, axes, 1.0 / spec.half, spec.a);
    shape.radius = 1;
    setBounds(shape, spec, axes, spec.half, spec.half, false);
  } else {
    const glm::dvec3 along = spec.b - spec.a;
    const double length = glm::length(along);
    const Axes axes = axesOf(length > 0 ? along : spec.axis, spec.across);
    setRows(shape, axes, {1, 1 / spec.thickness, 1}, spec.a);
    // If one ball contains the other, the cone is nearly that ball alone.
    const double cosine = length > 0 ? std::clamp((spec.radius_a - spec.radius_b) / length, -0.99, 0.99) : 0;
    shape.radius = static_cast<float>(spec.radius_a);
    shape.length = static_cast<float>(length);
    shape.cosine = static_cast<float>(cosine);
    shape.slope = static_cast<float>(cosine / std::sqrt(1 - cosine * cosine));
    const glm::dvec3 unit{1, spec.thickness, 1};
    setBounds(shape, spec, axes, spec.radius_a * unit, spec.radius_b * unit, false);
  }
  shape.tiny = 1e-3f * shape.radius;
}

}  // namespace

ShapeSpec ShapeSpec::blend(double mm) const {
  ShapeSpec out = *this;
  out.blend_mm = mm;
  return out;
}
ShapeSpec ShapeSpec::shell(double mm) const {
  ShapeSpec out = *this;
  out.shell_mm = mm;
  return out;
}
ShapeSpec ShapeSpec::carve() const {
  ShapeSpec out = *this;
  out.carves = true;
  return out;
}
ShapeSpec ShapeSpec::flat(const glm::dvec3& direction, double factor) const {
  ShapeSpec out = *this;
  out.kind = ShapeKind::kStretchedCone;
  out.across = direction;
  out.thickness = factor;
  return out;
}
ShapeSpec ShapeSpec::turned(const glm::dvec3& z, const glm::dvec3& y) const {
  ShapeSpec out = *this;
  out.axis = z;
  out.across = y;
  return out;
}
ShapeSpec ShapeSpec::mirrored() const {
  ShapeSpec out = *this;
  out.a = mirroredX(a);
  out.b = mirroredX(b);
  out.axis = mirroredX(axis);
  out.across = mirroredX(across);
  return out;
}

ShapeSpec ball(const glm::dvec3& centre, double radius) { return cone(centre, centre, radius, radius); }
ShapeSpec cone(const glm::dvec3& a, const glm::dvec3& b, double radius_a, double radius_b) {
  ShapeSpec out;
  out.a = a;
  out.b = b;
  out.radius_a = radius_a;
  out.radius_b = radius_b;
  return out;
}
ShapeSpec ellipsoid(const glm::dvec3& centre, const glm::dvec3& semi_axes) {
  ShapeSpec out;
  out.kind = ShapeKind::kStretchedCone;
  out.a = out.b = centre;
  out.half = semi_axes;
  return out;
}
ShapeSpec box(const glm::dvec3& centre, const glm::dvec3& half_edges, double rounding) {
  ShapeSpec out;
  out.kind = ShapeKind::kBox;
  out.a = out.b = centre;
  out.half = half_edges;
  out.radius_a = rounding;
  return out;
}
ShapeSpec cylinder(const glm::dvec3& a, const glm::dvec3& b, double radius, double rounding) {
  ShapeSpec out;
  out.kind = ShapeKind::kCylinder;
  out.a = out.b = 0.5 * (a + b);
  out.axis = b - a;
  out.half = {radius, radius, 0.5 * glm::length(b - a)};
  out.radius_a = rounding;
  return out;
}

Shape prepared(const ShapeSpec& spec) {
  Shape shape{};
  shape.kind = spec.kind;
  shape.carves = spec.carves;
  shape.blend = static_cast<float>(spec.blend_mm);
  shape.shell = static_cast<float>(spec.shell_mm);
  if (spec.kind == ShapeKind::kCone || spec.kind == ShapeKind::kStretchedCone) {
    prepareCone(shape, spec);
    return shape;
  }
  const Axes axes = axesOf(spec.axis, spec.across);
  setRows(shape, axes, {1, 1, 1}, spec.a);
  shape.radius = static_cast<float>(spec.radius_a);
  for (int i = 0; i < 3; ++i) shape.half[i] = static_cast<float>(spec.half[i] - spec.radius_a);
  setBounds(shape, spec, axes, spec.half, spec.half, true);
  return shape;
}

float distanceTo(const Shape& shape, float x, float y, float z) {
  switch (shape.kind) {
    case ShapeKind::kCone:
      return distance<ShapeKind::kCone>(shape, x, y, z);
    case ShapeKind::kStretchedCone:
      return distance<ShapeKind::kStretchedCone>(shape, x, y, z);
    case ShapeKind::kBox:
      return distance<ShapeKind::kBox>(shape, x, y, z);
    case ShapeKind::kCylinder:
      break;
  }
  return distance<ShapeKind::kCylinder>(shape, x, y, z);
}

}  // namespace kiln::phantom
