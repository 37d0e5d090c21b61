// Shading of samples: the material and the lights. Shared by jobs, kernels and the reference renderer.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

namespace kiln {

/// - kHeadlight: at the eye.
/// - kDirectional: far away, in a direction of the world.
/// - kPoint: at a place.
/// - kCamera: far away, in a direction of the camera: the light moves with the camera.
enum class LightKind { kHeadlight, kDirectional, kPoint, kCamera };

/// Returns whether the light's place is a direction.
constexpr bool isFar(LightKind kind) { return kind == LightKind::kDirectional || kind == LightKind::kCamera; }

/// A light without falloff and without shadows.
struct Light {
  LightKind kind = LightKind::kHeadlight;
  /// kDirectional: direction towards the light, of any positive length; kCamera: the direction in the camera's axes, x
  /// to the right, y up and z towards the eye; kPoint: the light's position. unit: world.
  glm::dvec3 place{0, 0, 1};
  glm::dvec3 color{1};  // linear light
  double intensity = 1;
  bool operator==(const Light&) const = default;
};

/// Blinn-Phong shading. A sample with normal n, seen from direction v, sends colour·(ambient + Σ L·diffuse·n·l) + Σ
/// L·specular·(n·h)^power to the eye. L is a light's colour times intensity, l the direction to the light, h the half
/// vector of l and v. n is turned towards the eye, so both sides are lit; a light behind the surface adds nothing. With
/// a headlight, l = h = v.
/// source: Blinn 1977.
struct Shading {
  bool phong = true;  // model "phong"; false is "none": colours of the transfer function
  double ambient = 0.2, diffuse = 0.8, specular = 0.2, power = 16;
  std::vector<Light> lights = {Light{}};
  bool operator==(const Shading&) const = default;
};

}  // namespace kiln
