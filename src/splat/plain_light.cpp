#include "splat/plain_light.h"

namespace kiln {

bool isPlain(const Shading& shading) {
  if (!shading.phong) return true;
  return shading.lights.size() == 1 && shading.lights[0].kind == LightKind::kHeadlight &&
         shading.lights[0].color == glm::dvec3(1);
}

PlainLight plainLight(const Shading& shading, float gradient_noise, const Projector& level) {
  const double intensity = shading.lights.empty() ? 0 : shading.lights[0].intensity;
  PlainLight out;
  out.phong = shading.phong && isPlain(shading);
  out.ambient = static_cast<float>(shading.ambient);
  out.diffuse = static_cast<float>(intensity * shading.diffuse);
  out.specular = static_cast<float>(intensity * shading.specular);
  out.power = static_cast<float>(shading.power);
  out.least_gradient_squared = gradient_noise * gradient_noise;
  out.view_from_index_gradient = level.viewFromIndexGradient();
  return out;
}

}  // namespace kiln
