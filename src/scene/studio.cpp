#include "scene/shading.h"

namespace kiln {

Shading studioShading() {
  const auto light = [](const glm::dvec3& place, const glm::dvec3& color, double intensity) {
    Light out;
    out.kind = LightKind::kCamera;
    out.place = place;
    out.color = color;
    out.intensity = intensity;
    return out;
  };
  Light key = light({-0.8, 0.8, 0.7}, {1, 0.97, 0.93}, 1.15);
  key.shadow.casts = true;
  const Light fill = light({1, 0.1, 0.7}, {0.93, 0.97, 1}, 0.22);
  const Light rim = light({0.5, 0.8, -0.5}, {1, 1, 1}, 0.5);
  Shading out;
  out.ambient = 0.25;
  out.power = 24;
  out.lights = {key, fill, rim};
  out.occlusion.strength = 1;
  out.occlusion.diffuse = true;
  return out;
}

}  // namespace kiln
