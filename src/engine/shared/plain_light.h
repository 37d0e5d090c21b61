// The light of most pictures, one white headlight, as kernels take it that go by vectors. Other lights are the
// Shader's, a sample at a time.
#pragma once

#include <glm/mat3x3.hpp>

#include "engine/shared/projector.h"
#include "scene/shading.h"

namespace kiln {

/// Gradients are multiplied by a power of two before they are squared, whose squares floats hold of values from 1e-30
/// to 1e30 a voxel; and the square, so multiplied, below which one has no direction.
struct GradientScale {
  float factor = 1, least_squared = 0;
  GradientScale() = default;
  /// `noise`: the length below which a gradient has no direction. unit: value per voxel.
  explicit GradientScale(float noise);
};

/// Of equal directions, so that squares of its coordinates are what floats hold, too.
glm::mat3 withoutLength(const glm::mat3& m);

struct PlainLight {
  bool phong = false;
  float ambient = 0, diffuse = 0, specular = 0, power = 0;
  GradientScale gradient;
  glm::mat3 view_from_index_gradient{1};  // its length says nothing
};

/// Whether nothing of `shading` is more than a PlainLight.
bool isPlain(const Shading& shading);

/// Of a level; without phong where that is not all. `gradient_noise` as Shader has it.
PlainLight plainLight(const Shading& shading, float gradient_noise, const Projector& level);

}  // namespace kiln
