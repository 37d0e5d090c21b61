// One eye of a pair: both look in parallel, and their pictures are shifted so that what is at the distance of
// convergence has the same place in both. Nothing is turned in, so that no height differs.
#pragma once

#include <optional>

#include "scene/camera.h"

namespace kiln {

enum class StereoEye { kLeft, kRight };

struct Stereo {
  StereoEye eye = StereoEye::kLeft;
  double interocular = 0;             // between both eyes. unit: world
  std::optional<double> convergence;  // depth; else the target's distance from the eye. unit: world
  bool operator==(const Stereo&) const = default;
};

/// The view of the camera, or where `stereo` is given, of that eye of a pair of which the camera is the middle. throws:
/// as resolve; Error kUsage for an orthographic camera, in which depth shifts nothing.
View resolve(const Camera& camera, const std::optional<Stereo>& stereo, const ImageSize& size);

}  // namespace kiln
