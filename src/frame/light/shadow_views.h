// The views of a light in which its shadow maps are drawn: a parallel view along a far light, a perspective view from a
// point light, or six views around a point light that the volumes surround.
// Invariant. The views depend on the light, the box and the edge of the map, never on the picture's crop.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "engine/shared/deep_shadow_map.h"
#include "scene/camera/camera.h"
#include "scene/shading.h"

namespace kiln {

struct ShadowView {
  View view;
  DepthRange depths;  // of the box
};

/// Returns the world direction of a camera light's place, seen by `eye`.
glm::dvec3 worldDirection(const Light& camera_light, const View& eye);
/// Returns a light that does not move with the camera.
Light standing(Light light, const View& eye);

/// Returns the lights that a soft light is the mean of, without camera lights: the light itself if it is not soft, else
/// kSoftLights on a disc, whose angle from `centre` is the light's softness.
std::vector<Light> pointsOf(const Light& light, const View& eye, const glm::dvec3& centre);
/// Points of a soft light. A penumbra of so many pixels has one shadow border a pixel.
inline constexpr int kSoftLights = 16;

/// Least edge of a map: beside its margins some pixels are left. unit: pixels.
inline constexpr int kLeastShadowEdge = 8;
/// Most views of a light: the faces of a cube. unit: views.
inline constexpr std::size_t kMostShadowViews = 6;
/// Returns the views of a light that together contain the points. `edge_px`: longest edge of a map. requires: a
/// directional or point light; edge_px >= kLeastShadowEdge; points that are not all equal.
std::vector<ShadowView> shadowViews(const Light& light, std::span<const glm::dvec3> points, int edge_px);

/// Returns the largest edge of a map pixel in the box. unit: world.
double pixelEdge(const ShadowView& view);

}  // namespace kiln
