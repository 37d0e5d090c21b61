// Phong shading of a sample, as scene/shading.h defines it, shared by all engines. Parameters that are constant over
// samples are computed once for each level of a frame; the inline rest cannot fail. A single headlight, the common
// case, costs one product and one power. Source: Blinn 1977. Differs: normals turn towards the eye (`seenNormal`).
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "engine/shared/classified_range.h"
#include "engine/shared/classifier.h"
#include "engine/shared/illumination.h"
#include "engine/shared/plain_light.h"
#include "engine/shared/projector.h"
#include "scene/camera/camera.h"
#include "scene/shading.h"
#include "scene/transfer/preset_ranges.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// Noise threshold of gradients, as a fraction of the classified range per voxel. Samples with shorter gradients are
/// not shaded.
inline constexpr double kGradientNoise = 1e-5;
/// Length of short gradients of a volume. unit: value per voxel.
inline float gradientSizeOf(const Manifest& manifest, const TransferFunction& function) {
  // Gradients of labels are gradients of opacity, whose range is 1.
  if (manifest.volume_class == VolumeClass::kLabels) return static_cast<float>(kGradientNoise);
  const ValueRange range =
      function.surfaces.empty() ? classifiedRange(function, manifest.range) : usableRange(manifest);
  return range.empty() ? 0.0f : static_cast<float>(kGradientNoise * (range.hi - range.lo));
}

/// Returns the sign that turns gradients out of matter: -1 if the highest values are at least as opaque as the lowest
/// values, as of surfaces and labels, else 1.
inline float outwardSignOf(const TransferFunction& function) {
  const std::vector<TransferPoint>& points = function.points;
  return !points.empty() && points.back().opacity < points.front().opacity ? 1.0f : -1.0f;
}

/// Returns true if all labels that are shown are opaque within a voxel, or all surfaces are. The points of a function
/// always have a translucent part. unit: mean spacing of voxels: world.
inline bool showsOutsidesOnly(const TransferFunction& function, double spacing) {
  if (!function.labels.empty() && function.unitIn(spacing) > spacing) return false;
  const auto opaque = [](const auto& shown) { return shown.opacity == 0 || shown.opacity >= 1; };
  return !(function.labels.empty() && function.surfaces.empty()) && std::ranges::all_of(function.labels, opaque) &&
         std::ranges::all_of(function.surfaces, opaque);
}

inline GradientSense gradientSenseOf(const Manifest& manifest, const TransferFunction& function) {
  const float size = gradientSizeOf(manifest, function);
  // A surface has a direction wherever its values differ.
  return {function.surfaces.empty() ? size : 0, size, outwardSignOf(function),
          showsOutsidesOnly(function, manifest.geometry().meanSpacing())};
}

/// Cosines to the eye of normals that point away from the eye, but are lit as at a silhouette. A ray that grazes a ball
/// of ten voxels' radius has its sample up to 1.5 voxels behind the contour, at a cosine of -0.15. From there to -0.3
/// the normal turns. Figures: engine/shared/decisions/light.md.
struct GrazingNormal {
  static constexpr float kKept = -0.15f, kReversed = -0.3f;

  float reversed = kReversed;
  /// The factor on a normal's part across the view, between `reversed` and 0: from -1 to 1.
  float slope = 2 / (kKept - kReversed), offset = 1 - slope * kKept;

  /// Opaque matter has no inside that is seen: at a sharp edge a ray has its sample behind the contour at any cosine.
  static constexpr GrazingNormal ofOpaque() { return {-2, 0, 1}; }
};

/// Returns the normal with which a sample is lit. `outward`: unit normal out of matter; `facing`: its cosine to the
/// eye. Behind a silhouette the reversed normal would point into matter, where no light is: there the normal is
/// mirrored at the plane across the view. Continuous.
inline glm::vec3 seenNormal(const glm::vec3& outward, float facing, const glm::vec3& to_eye,
                            const GrazingNormal& grazing) {
  if (facing >= 0) return outward;
  if (facing <= grazing.reversed) return -outward;
  const float across = std::min(grazing.slope * facing + grazing.offset, 1.0f);
  return glm::normalize(across * (outward - facing * to_eye) - facing * to_eye);
}

/// unit: linear light.
struct Color {
  float r, g, b;
};

class Shader {
 public:
  /// A light with a place, in view space.
  struct PlacedLight {
    bool point;
    glm::vec3 place;  // unit vector towards the light, or its position
    glm::vec3 color;
    ShadowLookup shadow;
    /// Returns a unit vector; zero at the light itself, which has no direction there.
    glm::vec3 towards(const glm::vec3& at) const {
      if (!point) return place;
      const glm::vec3 way = place - at;
      return glm::dot(way, way) > 0 ? glm::normalize(way) : glm::vec3(0);
    }
  };
  /// Scattered light by direction: (1 - g²) / (1 + g² - 2 g cosine)^(3/2).
  struct Phase {
    float numerator = 1, squared = 1, twice = 0;
    float operator()(float cosine) const {
      const float base = squared - twice * cosine;
      return numerator / (base * std::sqrt(base));
    }
  };
  /// Everything that the light of a level's samples depends on.
  struct Model {
    bool phong = false, perspective = false, has_headlight = false, shadowed = false, occludes_diffuse = false;
    bool scatters = false;   // light is scattered by a medium, not reflected by surfaces
    bool grey = true;        // all lights have equal channels
    bool dims_flat = false;  // shadows and occlusion take light away from samples without direction
    float ambient = 0, diffuse = 0, specular = 0, power = 0;
    GradientScale gradient;
    GrazingNormal grazing;
    glm::mat3 view_from_index_gradient{1};
    glm::vec3 headlight{0};  // sum of all headlights
    std::vector<PlacedLight> lights;
    AmbientLookup occlusion;
    Phase phase;  // if light is scattered; the albedo is a factor of `ambient` and `diffuse`
  };

  Shader() = default;
  /// Shadows are drawn if there is an `illumination`, which outlives the object.
  Shader(const Shading& shading, const View& view, const GradientSense& gradients, const Projector& level,
         const Illumination* illumination = nullptr);

  const Model& model() const { return m_; }

  /// Light that a sample of `material` at `view_point` sends to the eye. `index_gradient` is along the axes of the
  /// level. unit: gradient: value per voxel; view_point: world, in view space.
  Color operator()(const Material& material, const glm::vec3& index_gradient, const glm::dvec3& view_point) const {
    const glm::vec3 scaled = m_.gradient.factor * index_gradient;
    if (!m_.phong) return {material.r, material.g, material.b};
    if (m_.scatters) return scattered(material, view_point);
    if (!(glm::dot(scaled, scaled) > m_.gradient.least_squared)) return withoutDirection(material, view_point);
    return lit(material, scaled, view_point, m_.grazing);
  }

  /// Light of a sample on a cut face. `index_normal` is the clip plane's normal, so no noise threshold applies.
  /// requires: a length above zero.
  Color onCut(const Material& material, const glm::vec3& index_normal, const glm::dvec3& view_point) const {
    if (!m_.phong) return {material.r, material.g, material.b};
    if (m_.scatters) return scattered(material, view_point);
    // A face that looks away from the eye is reversed.
    return lit(material, index_normal, view_point, {.reversed = 0});
  }

  /// Unit normal in view space, turned towards the eye; 0 if the gradient has no direction.
  glm::vec3 normal(const glm::vec3& index_gradient, const glm::dvec3& view_point) const {
    const glm::vec3 scaled = m_.gradient.factor * index_gradient;
    if (!(glm::dot(scaled, scaled) > m_.gradient.least_squared)) return glm::vec3(0);
    return normalOnCut(scaled, view_point);
  }
  glm::vec3 normalOnCut(const glm::vec3& index_normal, const glm::dvec3& view_point) const {
    const glm::vec3 out = glm::normalize(m_.view_from_index_gradient * index_normal), to_eye = toEye(view_point);
    return glm::dot(out, to_eye) < 0 ? -out : out;
  }

 private:
  Color scattered(const Material& material, const glm::dvec3& view_point) const {
    const glm::vec3 at(view_point), to_eye = toEye(view_point);
    glm::vec3 light = glm::vec3(m_.ambient * m_.occlusion(at, glm::vec3(0))) + m_.diffuse * m_.phase(-1) * m_.headlight;
    for (const PlacedLight& from : m_.lights) {
      const float share = from.shadow.none() ? 1 : from.shadow.share(at);
      light += m_.diffuse * m_.phase(-glm::dot(from.towards(at), to_eye)) * share * from.color;
    }
    return {material.r * light.r, material.g * light.g, material.b * light.b};
  }

  // A sample without direction has the colour of its material, less the light that occlusion and shadows take away.
  Color withoutDirection(const Material& material, const glm::dvec3& view_point) const {
    if (!m_.dims_flat) return {material.r, material.g, material.b};
    const glm::vec3 at(view_point);
    const float open = m_.occlusion(at, glm::vec3(0));
    glm::vec3 all = m_.headlight, reaching = m_.headlight;
    for (const PlacedLight& light : m_.lights) {
      all += light.color;
      reaching += light.shadow(at, glm::vec3(0), light.towards(at)) * light.color;
    }
    const auto share = [&](int c) {
      const float lost = all[c] > 0 ? 1 - reaching[c] / all[c] : 0;
      return (m_.ambient * open + m_.diffuse * (1 - lost) * (m_.occludes_diffuse ? open : 1)) /
             (m_.ambient + m_.diffuse);
    };
    return {material.r * share(0), material.g * share(1), material.b * share(2)};
  }

  glm::vec3 toEye(const glm::dvec3& view_point) const {
    return m_.perspective ? -glm::normalize(glm::vec3(view_point)) : glm::vec3(0, 0, -1);
  }

  Color lit(const Material& material, const glm::vec3& index_gradient, const glm::dvec3& view_point,
            const GrazingNormal& grazing) const {
    glm::vec3 normal = m_.view_from_index_gradient * index_gradient;
    const glm::vec3 to_eye = toEye(view_point);
    const float length = glm::length(normal), facing = glm::dot(normal, to_eye) / length;
    const float cosine = std::min(std::abs(facing), 1.0f);
    const bool needs_normal = !m_.lights.empty() || !m_.occlusion.none();
    if (needs_normal) normal = seenNormal(normal / length, facing, to_eye, grazing);
    const float open = m_.occlusion(glm::vec3(view_point), normal);
    const float diffuse = m_.occludes_diffuse ? m_.diffuse * open : m_.diffuse;
    glm::vec3 matte = glm::vec3(m_.ambient * open) + diffuse * cosine * m_.headlight;
    glm::vec3 gloss =
        m_.specular > 0 && m_.has_headlight ? m_.specular * std::pow(cosine, m_.power) * m_.headlight : glm::vec3(0);
    for (const PlacedLight& light : m_.lights) {
      const glm::vec3 to_light = light.towards(glm::vec3(view_point));
      const float lit = glm::dot(normal, to_light);
      if (!(lit > 0)) continue;
      const glm::vec3 reaching = light.shadow(glm::vec3(view_point), normal, to_light) * light.color;
      matte += diffuse * lit * reaching;
      if (!(m_.specular > 0)) continue;
      const float halfway = std::clamp(glm::dot(normal, glm::normalize(to_light + to_eye)), 0.0f, 1.0f);
      gloss += m_.specular * std::pow(halfway, m_.power) * reaching;
    }
    return {material.r * matte.r + gloss.r, material.g * matte.g + gloss.g, material.b * matte.b + gloss.b};
  }

  Model m_;
};

}  // namespace kiln
