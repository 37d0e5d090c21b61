// Light of most pictures, a single white headlight, in the form that vector kernels need. `Shader` computes all other
// lights, one sample at a time.
#pragma once

#include <glm/mat3x3.hpp>

#include "engine/shared/projector.h"
#include "scene/shading.h"

namespace kiln {

/// How gradients of a volume tell of its surfaces.
struct GradientSense {
  float noise = 0;          // shorter gradients have no direction. unit: value per voxel
  float size = 0;           // short gradients of the volume; 0: unknown. unit: value per voxel
  float outward_sign = -1;  // the factor that turns gradients out of matter
  bool opaque = false;      // rays see matter from its outside only
};

/// Scale and noise threshold of gradients. Gradients are multiplied by `factor`, a power of two with a sign, so that
/// their squares fit floats for values from 1e-30 to 1e30 per voxel. A scaled square of at most `least_squared` has no
/// direction.
struct GradientScale {
  float factor = 1, least_squared = 0;  // the factor's sign turns gradients out of matter
  float directed = 1;                   // a gradient's part into matter, longer than the noise. unit: value per voxel
  GradientScale() = default;
  explicit GradientScale(const GradientSense& sense);
};

/// Returns `m` scaled by a power of two so that its largest entry is near one and squares of products with it fit
/// floats.
glm::mat3 withoutLength(const glm::mat3& m);

struct PlainLight {
  bool phong = false;
  float ambient = 0, diffuse = 0, specular = 0, power = 0;
  GradientScale gradient;
  glm::mat3 view_from_index_gradient{1};  // directions only; scaled by withoutLength
};

/// Returns true if PlainLight can represent `shading`.
bool isPlain(const Shading& shading);

/// Light for one level; without phong if `shading` is not plain.
PlainLight plainLight(const Shading& shading, const GradientSense& gradients, const Projector& level);

}  // namespace kiln
