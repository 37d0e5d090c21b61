// Shading of samples: the material and the lights. Shared by jobs, kernels and the reference renderer.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

namespace kiln {

/// - kHeadlight: at the eye.
/// - kDirectional: far away, in a direction of the world.
/// - kPoint: at a place.
/// - kCamera: far away, in a direction of the camera: the light moves with the camera.
enum class LightKind { kHeadlight, kDirectional, kPoint, kCamera };

/// Returns whether the light's place is a direction.
constexpr bool isFar(LightKind kind) { return kind == LightKind::kDirectional || kind == LightKind::kCamera; }

/// The shadow that the volumes cast in a light.
struct Shadow {
  bool casts = false;
  double strength = 1;  // share of the light that an opaque object takes away, 0 to 1
  double softness = 0;  // angle of the light, seen from the volume. unit: degrees
  int resolution = 0;   // largest edge of a shadow map; 0: by the volumes and the picture. unit: pixels
  bool operator==(const Shadow&) const = default;
};

/// A light without falloff.
struct Light {
  LightKind kind = LightKind::kHeadlight;
  /// kDirectional: direction towards the light, of any positive length; kCamera: the direction in the camera's axes, x
  /// to the right, y up and z towards the eye; kPoint: the light's position. unit: world.
  glm::dvec3 place{0, 0, 1};
  glm::dvec3 color{1};  // linear light
  double intensity = 1;
  Shadow shadow = {};  // a headlight has none: the eye sees no shadow of its own light
  bool operator==(const Light&) const = default;
};

/// Returns the direction of a camera light in view space, which has y down and z along the view. Any length.
inline glm::dvec3 viewDirection(const Light& camera_light) {
  const glm::dvec3& place = camera_light.place;
  return {place.x, -place.y, -place.z};
}

/// The share of light that matter around a sample keeps away from it.
struct AmbientOcclusion {
  double strength = 0;   // 0: none, 1: all
  double radius = 0;     // beyond which matter does not occlude; 0: a tenth of the volumes' longest edge. unit: world
  bool diffuse = false;  // occludes diffuse light, too
  bool operator==(const AmbientOcclusion&) const = default;
};

/// Light that a medium turns into other directions, once. A sample sends colour·albedo·(ambient + Σ L·diffuse·phase) to
/// the eye, whatever its gradient. Shadows of the medium itself take light away.
/// source: Henyey and Greenstein 1941.
struct Scattering {
  double albedo = 1;      // share of the light that is scattered, 0..1
  double anisotropy = 0;  // mean cosine of the angle between the light's old and new direction, -1..1, exclusive
  /// Returns the light in a direction, relative to a medium that scatters evenly. `cosine`: of the angle between the
  /// light's old and new direction.
  double phase(double cosine) const {
    const double g = anisotropy, squared = 1 + g * g - 2 * g * cosine;
    return (1 - g * g) / (squared * std::sqrt(squared));
  }
  bool operator==(const Scattering&) const = default;
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
  bool shadows = false;  // all lights cast shadows
  AmbientOcclusion occlusion = {};
  /// Instead of Blinn-Phong; a transfer function's, never a picture's.
  std::optional<Scattering> scattering = {};
  bool operator==(const Shading&) const = default;
};

/// The light of `--look studio`, for a camera's view: a key from the upper left that casts shadows, a fill from the
/// right without one, and a rim from behind that lights edges. Near matter occludes ambient and diffuse light.
Shading studioShading();

/// Returns whether the volumes cast shadows in the light.
inline bool castsShadows(const Shading& shading, const Light& light) {
  return shading.phong && (shading.shadows || light.shadow.casts) && light.kind != LightKind::kHeadlight;
}

/// Returns whether the volumes cast shadows in some light.
inline bool castsShadows(const Shading& shading) {
  return std::any_of(shading.lights.begin(), shading.lights.end(),
                     [&](const Light& light) { return castsShadows(shading, light); });
}

/// Returns whether a sample's light depends on the volume around it: on shadows or ambient occlusion.
inline bool isShaded(const Shading& shading) {
  return (shading.phong && shading.occlusion.strength > 0) || castsShadows(shading);
}

}  // namespace kiln
