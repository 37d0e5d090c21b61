// Shading, the same for every kernel: Phong with a headlight, two-sided (DESIGN §10). All that no sample changes is
// prepared once for each level of a frame; what is left is inline and does not fail.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "scene/render_job.h"
#include "splat/classifier.h"
#include "splat/projector.h"

namespace kiln {

/// A gradient shorter than this part of the volume's value range per voxel is noise: such a sample is not shaded.
inline constexpr double kGradientNoise = 1e-5;

/// Linear light.
struct Color {
  float r, g, b;
};

class Shader {
 public:
  Shader() = default;
  /// `gradient_noise` is the length below which a gradient has no direction. unit: value per voxel of `level`.
  Shader(const Shading& shading, float gradient_noise, const Projector& level)
      : phong_(shading.phong),
        perspective_(level.perspective()),
        ambient_(static_cast<float>(shading.ambient)),
        diffuse_(static_cast<float>(shading.diffuse)),
        specular_(static_cast<float>(shading.specular)),
        power_(static_cast<float>(shading.power)),
        least_gradient_squared_(gradient_noise * gradient_noise),
        view_from_index_gradient_(level.viewFromIndexGradient()) {}

  /// The light that a sample of `material` sends to the eye. `index_gradient` is along the axes of the level,
  /// `view_point` where the sample is. unit: value per voxel; world, in view space.
  Color operator()(const Material& material, const glm::vec3& index_gradient, const glm::dvec3& view_point) const {
    if (!phong_ || !(glm::dot(index_gradient, index_gradient) > least_gradient_squared_))
      return {material.r, material.g, material.b};
    const glm::vec3 normal = view_from_index_gradient_ * index_gradient;
    const glm::vec3 to_eye = perspective_ ? -glm::normalize(glm::vec3(view_point)) : glm::vec3(0, 0, -1);
    const float cosine = std::min(std::abs(glm::dot(normal, to_eye)) / glm::length(normal), 1.0f);
    const float matte = ambient_ + diffuse_ * cosine;
    const float gloss = specular_ > 0 ? specular_ * std::pow(cosine, power_) : 0.0f;
    return {material.r * matte + gloss, material.g * matte + gloss, material.b * matte + gloss};
  }

 private:
  bool phong_ = false, perspective_ = false;
  float ambient_ = 0, diffuse_ = 0, specular_ = 0, power_ = 0;
  float least_gradient_squared_ = 0;
  glm::mat3 view_from_index_gradient_{1};
};

}  // namespace kiln
