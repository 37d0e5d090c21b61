// Normals of samples, one at a time, for the planes of a picture.
#pragma once

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "engine/pixel/slab_context.h"
#include "engine/shared/shade.h"
#include "scene/clip_region.h"

namespace kiln {

/// Position and gradient of a sample.
struct SampleSite {
  glm::dvec3 index;         // in the level's index space
  glm::dvec3 view;          // in view space
  glm::dvec3 to_eye;        // direction in the level's index space
  glm::vec3 gradient;       // unit: value per voxel; 0 if not finite
  glm::vec3 face_slope{0};  // normal of the face that lights a share of the sample, of any length above 0
  float face_share = 0;
};

/// Mean normal of a sample's piece in view space, no longer than 1; 0 if the sample has no direction.
inline glm::vec3 sampleNormal(const Appearance& look, const SampleSite& site) {
  const glm::vec3 own = look.shader.normal(site.gradient, site.view);
  if (site.face_share == 0) return own;
  return glm::mix(own, look.shader.normalOnCut(site.face_slope, site.view), site.face_share);
}

/// Unit normal of a cut face at a point on it, in view space.
inline glm::vec3 faceNormal(const Appearance& look, const SampleSite& site) {
  const glm::vec3* const face = look.clip->cutGradient(site.index, site.to_eye);
  return face != nullptr ? look.shader.normalOnCut(*face, site.view) : glm::vec3(0);
}

}  // namespace kiln
