// The parts of a picture that change from frame to frame.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "job/stereo.h"
#include "job/transfer_function_choice.h"
#include "scene/camera/camera_path.h"
#include "scene/clip_region.h"
#include "scene/keyframes.h"
#include "scene/shading.h"

namespace kiln {

/// An empty list of keys leaves the still picture's value. All keys of a list have equally many lights of the same
/// kinds in the same order, or equally many planes; a convergence stands in all keys of eyes or in none.
struct Animation {
  CameraPath camera;
  std::vector<Key<TransferFunctionChoice>> functions;
  std::vector<Key<std::vector<Light>>> lights;
  std::vector<Key<std::vector<ClipPlane>>> clip;  // in addition to the still picture's planes
  std::vector<Key<Stereo>> stereo;                // the still picture selects the eye
  bool any() const {
    return camera.index() != 0 || !functions.empty() || !lights.empty() || !clip.empty() || !stereo.empty();
  }
  /// Returns the frames from the first key to the last; frame 1 without keys.
  std::vector<int> frames() const;
};

/// The lights, planes and eyes between two keys' ones. requires: equal sizes and kinds, both or none with a
/// convergence, t in [0, 1].
std::vector<Light> mixed(const std::vector<Light>& a, const std::vector<Light>& b, double t);
std::vector<ClipPlane> mixed(const std::vector<ClipPlane>& a, const std::vector<ClipPlane>& b, double t);
Stereo mixed(const Stereo& a, const Stereo& b, double t);

/// Returns whether a direction between both exists: opposite directions have none.
bool mayMix(const glm::dvec3& a, const glm::dvec3& b);

}  // namespace kiln
