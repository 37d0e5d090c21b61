// Normals of samples, one at a time, for the planes of a picture.
#pragma once

#include <glm/vec3.hpp>

#include "engine/pixel/slab_context.h"
#include "engine/shared/shade.h"
#include "scene/clip_region.h"

namespace kiln {

/// Position and gradient of a sample.
struct SampleSite {
  glm::dvec3 index;    // in the level's index space
  glm::dvec3 view;     // in view space
  glm::dvec3 to_eye;   // direction in the level's index space
  glm::vec3 gradient;  // unit: value per voxel; 0 if not finite
};

/// Unit normal in view space; 0 if the sample has no direction. Surfaces have no cut faces; faces that show values are
/// samples of their own.
inline glm::vec3 sampleNormal(const Appearance& look, const SampleSite& site) {
  const glm::vec3* const face = look.surfaces           ? nullptr
                                : look.faces != nullptr ? look.clip->borderGradient(site.index, site.to_eye)
                                                        : look.clip->cutGradient(site.index, site.to_eye);
  return face != nullptr ? look.shader.normalOnCut(*face, site.view) : look.shader.normal(site.gradient, site.view);
}

/// Unit normal of a cut face at a point on it, in view space.
inline glm::vec3 faceNormal(const Appearance& look, const SampleSite& site) {
  const glm::vec3* const face = look.clip->cutGradient(site.index, site.to_eye);
  return face != nullptr ? look.shader.normalOnCut(*face, site.view) : glm::vec3(0);
}

}  // namespace kiln
