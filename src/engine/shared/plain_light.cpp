#include "engine/shared/plain_light.h"

#include <algorithm>
#include <cmath>

namespace kiln {

namespace {

// Returns the power of two that brings `size` near one.
float factorToOne(float size) { return std::ldexp(1.0f, -std::clamp(std::ilogb(size), -120, 120)); }

}  // namespace

GradientScale::GradientScale(const GradientSense& sense) {
  // Keep a factor of 1 unless squares come near the limits of a float.
  const float size = sense.size;
  if (size > 0 && (size < 1e-8f || size > 1e8f)) factor = factorToOne(size);
  const float scaled = sense.noise * factor;
  least_squared = scaled * scaled;
  if (size > 0) directed = 2 * size;
  factor *= sense.outward_sign;
  directed *= -sense.outward_sign;
}

glm::mat3 withoutLength(const glm::mat3& m) {
  float most = 0;
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) most = std::max(most, std::abs(m[column][row]));
  }
  return most > 0 ? m * factorToOne(most) : m;
}

bool isPlain(const Shading& shading) {
  if (!shading.phong) return true;
  if (shading.scattering) return false;
  return shading.occlusion.strength == 0 && shading.lights.size() == 1 &&
         shading.lights[0].kind == LightKind::kHeadlight && shading.lights[0].color == glm::dvec3(1);
}

PlainLight plainLight(const Shading& shading, const GradientSense& gradients, const Projector& level) {
  const double intensity = shading.lights.empty() ? 0 : shading.lights[0].intensity;
  PlainLight out;
  out.phong = shading.phong && isPlain(shading);
  out.ambient = static_cast<float>(shading.ambient);
  out.diffuse = static_cast<float>(intensity * shading.diffuse);
  out.specular = static_cast<float>(intensity * shading.specular);
  out.power = static_cast<float>(shading.power);
  out.gradient = GradientScale(gradients);
  out.view_from_index_gradient = withoutLength(level.viewFromIndexGradient());
  return out;
}

}  // namespace kiln
