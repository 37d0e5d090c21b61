#include "engine/shared/shade.h"

namespace kiln {
namespace {

Shader::PlacedLight placed(const Light& light, const View& view, const glm::vec3& color) {
  if (light.kind == LightKind::kPoint)
    return {true, glm::vec3(view.view_from_world * glm::dvec4(light.place, 1)), color, {}};
  const glm::dvec3 towards =
      light.kind == LightKind::kCamera ? viewDirection(light) : glm::dmat3(view.view_from_world) * light.place;
  return {false, glm::vec3(glm::normalize(towards)), color, {}};
}

}  // namespace

Shader::Shader(const Shading& shading, const View& view, const GradientSense& gradients, const Projector& level,
               const Illumination* illumination) {
  m_.phong = shading.phong;
  m_.perspective = level.perspective();
  m_.ambient = static_cast<float>(shading.ambient);
  m_.diffuse = static_cast<float>(shading.diffuse);
  m_.specular = static_cast<float>(shading.specular);
  m_.power = static_cast<float>(shading.power);
  if (shading.scattering) {
    const auto albedo = static_cast<float>(shading.scattering->albedo);
    const auto g = static_cast<float>(shading.scattering->anisotropy);
    m_.scatters = true;
    m_.ambient *= albedo, m_.diffuse *= albedo;
    m_.phase = {1 - g * g, 1 + g * g, 2 * g};
  }
  m_.gradient = GradientScale(gradients);
  if (gradients.opaque) m_.grazing = GrazingNormal::ofOpaque();
  m_.view_from_index_gradient = withoutLength(level.viewFromIndexGradient());
  for (std::size_t i = 0; i < shading.lights.size(); ++i) {
    const Light& light = shading.lights[i];
    const glm::vec3 color(light.intensity * light.color);
    m_.grey = m_.grey && color == glm::vec3(color.r);
    if (light.kind == LightKind::kHeadlight) {
      m_.has_headlight = true;
      m_.headlight += color;
      continue;
    }
    m_.lights.push_back(placed(light, view, color));
    if (illumination == nullptr) continue;
    ShadowLookup& shadow = m_.lights.back().shadow = ShadowLookup(illumination->lights.at(i), view);
    m_.shadowed = m_.shadowed || !shadow.none();
  }
  if (illumination != nullptr && illumination->ambient) {
    m_.occlusion =
        AmbientLookup(*illumination->ambient, static_cast<float>(shading.occlusion.strength), view.view_from_world);
    m_.occludes_diffuse = shading.occlusion.diffuse;
  }
  m_.dims_flat = (m_.shadowed || !m_.occlusion.none()) && m_.ambient + m_.diffuse > 0;
}

}  // namespace kiln
