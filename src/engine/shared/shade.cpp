#include "engine/shared/shade.h"

namespace kiln {

Shader::Shader(const Shading& shading, const View& view, float gradient_noise, const Projector& level)
    : phong_(shading.phong),
      perspective_(level.perspective()),
      ambient_(static_cast<float>(shading.ambient)),
      diffuse_(static_cast<float>(shading.diffuse)),
      specular_(static_cast<float>(shading.specular)),
      power_(static_cast<float>(shading.power)),
      gradient_(gradient_noise),
      view_from_index_gradient_(withoutLength(level.viewFromIndexGradient())) {
  for (const Light& light : shading.lights) {
    const glm::vec3 color(light.intensity * light.color);
    if (light.kind == LightKind::kHeadlight) {
      has_headlight_ = true;
      headlight_ += color;
    } else if (light.kind == LightKind::kDirectional) {
      const glm::dvec3 towards = glm::dmat3(view.view_from_world) * light.place;
      lights_.push_back({false, glm::vec3(glm::normalize(towards)), color});
    } else if (light.kind == LightKind::kCamera) {
      // View space has y down and z along the view.
      const glm::dvec3 towards(light.place.x, -light.place.y, -light.place.z);
      lights_.push_back({false, glm::vec3(glm::normalize(towards)), color});
    } else {
      lights_.push_back({true, glm::vec3(view.view_from_world * glm::dvec4(light.place, 1)), color});
    }
  }
}

}  // namespace kiln
