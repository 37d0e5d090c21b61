// Mixes values of keyframes (Animation in job/render_job.h).
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "scene/camera/camera_spec.h"
#include "scene/clipping.h"
#include "scene/shading.h"

namespace kiln {

/// The lights, planes and eyes between two keys' ones. requires: equal sizes and kinds, both or none with a
/// convergence, t in [0, 1].
std::vector<Light> mixed(const std::vector<Light>& a, const std::vector<Light>& b, double t);
std::vector<ClipPlane> mixed(const std::vector<ClipPlane>& a, const std::vector<ClipPlane>& b, double t);
Stereo mixed(const Stereo& a, const Stereo& b, double t);

/// Returns whether a direction between both exists: opposite directions have none.
bool mayMix(const glm::dvec3& a, const glm::dvec3& b);

}  // namespace kiln
