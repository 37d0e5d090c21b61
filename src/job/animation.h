// What of a picture changes from frame to frame.
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

/// Where a list of keys is empty, the still picture's value holds. Keys of a list have as many lights, of the same
/// kinds in the same order, or as many planes; eyes in all keys or in none a convergence.
struct Animation {
  CameraPath camera;
  std::vector<Key<TransferFunctionChoice>> functions;
  std::vector<Key<std::vector<Light>>> lights;
  std::vector<Key<std::vector<ClipPlane>>> clip;  // in addition to the still picture's planes
  std::vector<Key<Stereo>> stereo;                // which eye is drawn, the still picture says
  bool any() const {
    return camera.index() != 0 || !functions.empty() || !lights.empty() || !clip.empty() || !stereo.empty();
  }
  /// From the first frame that something is said of to the last; 1 where there is none.
  std::vector<int> frames() const;
};

/// The lights, planes and eyes between two keys' ones. requires: equal sizes and kinds, both or none with a
/// convergence, t in [0, 1].
std::vector<Light> mixed(const std::vector<Light>& a, const std::vector<Light>& b, double t);
std::vector<ClipPlane> mixed(const std::vector<ClipPlane>& a, const std::vector<ClipPlane>& b, double t);
Stereo mixed(const Stereo& a, const Stereo& b, double t);

/// Whether something lies between two directions: whether they are not opposite ones.
bool mayMix(const glm::dvec3& a, const glm::dvec3& b);

}  // namespace kiln
