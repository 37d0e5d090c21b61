// Phong shading of a sample, as scene/shading.h defines it, shared by all engines. Parameters that are constant over
// samples are computed once for each level of a frame; the inline rest cannot fail. A single headlight, the common
// case, costs one product and one power. Source: Blinn 1977. Differs: normals turn towards the eye.
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

/// Noise threshold of gradients, as a fraction of the classified range per voxel. Samples with shorter gradients are
/// not shaded.
inline constexpr double kGradientNoise = 1e-5;
/// Noise threshold of a volume. unit: value per voxel.
inline float gradientNoiseOf(const Manifest& manifest, const TransferFunction& function) {
  // Gradients of labels are gradients of opacity, whose range is 1.
  if (manifest.volume_class == VolumeClass::kLabels) return static_cast<float>(kGradientNoise);
  const ValueRange range = classifiedRange(function, manifest.range);
  return range.empty() ? 0.0f : static_cast<float>(kGradientNoise * (range.hi - range.lo));
}

/// unit: linear light.
struct Color {
  float r, g, b;
};

class Shader {
 public:
  Shader() = default;
  /// `gradient_noise`: length below which a gradient has no direction. unit: value per voxel of `level`.
  Shader(const Shading& shading, const View& view, float gradient_noise, const Projector& level);

  /// Light that a sample of `material` at `view_point` sends to the eye. `index_gradient` is along the axes of the
  /// level. unit: gradient: value per voxel; view_point: world, in view space.
  Color operator()(const Material& material, const glm::vec3& index_gradient, const glm::dvec3& view_point) const {
    const glm::vec3 scaled = gradient_.factor * index_gradient;
    if (!phong_ || !(glm::dot(scaled, scaled) > gradient_.least_squared)) return {material.r, material.g, material.b};
    return lit(material, scaled, view_point);
  }

  /// Light of a sample on a cut face. `index_normal` is the clip plane's normal, so no noise threshold applies.
  /// requires: a length above zero.
  Color onCut(const Material& material, const glm::vec3& index_normal, const glm::dvec3& view_point) const {
    if (!phong_) return {material.r, material.g, material.b};
    return lit(material, index_normal, view_point);
  }

  /// Unit normal in view space, turned towards the eye; 0 if the gradient has no direction.
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
    glm::vec3 place;  // unit vector towards the light (directional) or position (point)
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
  glm::vec3 headlight_{0};  // sum of all headlights
  std::vector<ViewLight> lights_;
};

}  // namespace kiln
