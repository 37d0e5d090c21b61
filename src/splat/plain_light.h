// The light of most pictures, one white headlight, as kernels take it that go by vectors. Other lights are the
// Shader's, a sample at a time.
#pragma once

#include <glm/mat3x3.hpp>

#include "scene/shading.h"
#include "splat/projector.h"

namespace kiln {

struct PlainLight {
  bool phong = false;
  float ambient = 0, diffuse = 0, specular = 0, power = 0;
  float least_gradient_squared = 0;  // below it a gradient has no direction
  glm::mat3 view_from_index_gradient{1};
};

/// Whether nothing of `shading` is more than a PlainLight.
bool isPlain(const Shading& shading);

/// Of a level; without phong where that is not all. `gradient_noise` as Shader has it.
PlainLight plainLight(const Shading& shading, float gradient_noise, const Projector& level);

}  // namespace kiln
