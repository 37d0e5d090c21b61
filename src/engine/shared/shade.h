// Shading, the same for every kernel: what scene/shading.h says. All that no sample changes is prepared once for each
// level of a frame; what is left is inline and does not fail. A headlight, which most pictures have alone, costs one
// product and one power.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "engine/shared/classified_range.h"
#include "engine/shared/classifier.h"
#include "engine/shared/plain_light.h"
#include "engine/shared/projector.h"
#include "scene/camera/camera.h"
#include "scene/shading.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// A gradient shorter than this part of the values that are told apart per voxel is noise: such a sample is not shaded.
inline constexpr double kGradientNoise = 1e-5;
/// That of a volume of such values. unit: value per voxel.
inline float gradientNoiseOf(const Manifest& manifest, const TransferFunction& function) {
  // Of labels it is the gradient of their opacity.
  if (manifest.volume_class == VolumeClass::kLabels) return static_cast<float>(kGradientNoise);
  const ValueRange range = classifiedRange(function, manifest.range);
  return range.empty() ? 0.0f : static_cast<float>(kGradientNoise * (range.hi - range.lo));
}

/// Linear light.
struct Color {
  float r, g, b;
};

class Shader {
 public:
  Shader() = default;
  /// `gradient_noise` is the length below which a gradient has no direction. unit: value per voxel of `level`.
  Shader(const Shading& shading, const View& view, float gradient_noise, const Projector& level);

  /// The light that a sample of `material` sends to the eye. `index_gradient` is along the axes of the level,
  /// `view_point` where the sample is. unit: value per voxel; world, in view space.
  Color operator()(const Material& material, const glm::vec3& index_gradient, const glm::dvec3& view_point) const {
    const glm::vec3 scaled = gradient_.factor * index_gradient;
    if (!phong_ || !(glm::dot(scaled, scaled) > gradient_.least_squared)) return {material.r, material.g, material.b};
    return lit(material, scaled, view_point);
  }

  /// The same where `index_normal` is no measured gradient but has a direction for certain: a clip plane's. requires: a
  /// length above zero.
  Color onCut(const Material& material, const glm::vec3& index_normal, const glm::dvec3& view_point) const {
    if (!phong_) return {material.r, material.g, material.b};
    return lit(material, index_normal, view_point);
  }

  /// The normal that such a sample is lit by, turned towards the eye, of unit length, in view space; 0 where it is not
  /// shaded for want of a direction.
  glm::vec3 normal(const glm::vec3& index_gradient, const glm::dvec3& view_point) const {
    const glm::vec3 scaled = gradient_.factor * index_gradient;
    if (!(glm::dot(scaled, scaled) > gradient_.least_squared)) return glm::vec3(0);
    return normalOnCut(scaled, view_point);
  }
  glm::vec3 normalOnCut(const glm::vec3& index_normal, const glm::dvec3& view_point) const {
    const glm::vec3 out = glm::normalize(view_from_index_gradient_ * index_normal);
    return glm::dot(out, toEye(view_point)) < 0 ? -out : out;
  }

 private:
  struct ViewLight {
    bool point;
    glm::vec3 place;  // towards it, of unit length, or where it is
    glm::vec3 color;
  };

  glm::vec3 toEye(const glm::dvec3& view_point) const {
    return perspective_ ? -glm::normalize(glm::vec3(view_point)) : glm::vec3(0, 0, -1);
  }

  Color lit(const Material& material, const glm::vec3& index_gradient, const glm::dvec3& view_point) const {
    glm::vec3 normal = view_from_index_gradient_ * index_gradient;
    const glm::vec3 to_eye = toEye(view_point);
    const float facing = glm::dot(normal, to_eye);
    const float length = glm::length(normal);
    const float cosine = std::min(std::abs(facing) / length, 1.0f);
    glm::vec3 matte = ambient_ + diffuse_ * cosine * headlight_;
    glm::vec3 gloss =
        specular_ > 0 && has_headlight_ ? specular_ * std::pow(cosine, power_) * headlight_ : glm::vec3(0);
    if (!lights_.empty()) normal *= (facing < 0 ? -1.0f : 1.0f) / length;
    for (const ViewLight& light : lights_) {
      const glm::vec3 to_light = light.point ? glm::normalize(light.place - glm::vec3(view_point)) : light.place;
      const float lit = glm::dot(normal, to_light);
      if (!(lit > 0)) continue;
      matte += diffuse_ * lit * light.color;
      if (!(specular_ > 0)) continue;
      const float halfway = std::clamp(glm::dot(normal, glm::normalize(to_light + to_eye)), 0.0f, 1.0f);
      gloss += specular_ * std::pow(halfway, power_) * light.color;
    }
    return {material.r * matte.r + gloss.r, material.g * matte.g + gloss.g, material.b * matte.b + gloss.b};
  }

  bool phong_ = false, perspective_ = false, has_headlight_ = false;
  float ambient_ = 0, diffuse_ = 0, specular_ = 0, power_ = 0;
  GradientScale gradient_;
  glm::mat3 view_from_index_gradient_{1};
  glm::vec3 headlight_{0};  // the sum of all at the eye
  std::vector<ViewLight> lights_;
};

}  // namespace kiln
