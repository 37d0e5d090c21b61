// The user's camera settings; any of them may be missing.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "grid/geometry.h"
#include "scene/camera/camera.h"
#include "scene/camera/framing.h"

namespace kiln {

/// Either an eye or a framing; each key is optional. Defaults with an eye: target at the volume's centre, up superior,
/// fov 60, and an orthographic height that fits. Defaults without: `defaultFraming`, or a side seen straight; a target
/// then moves eye and target together. A named projection ignores the other projection's fov or height.
struct CameraSpec {
  std::optional<Projection> projection;
  std::optional<glm::dvec3> eye, target, up;
  std::optional<double> fov_deg, height;
  std::optional<Side> side;
  std::optional<double> azimuth_deg, elevation_deg, zoom;
  std::optional<glm::dvec2> pan;  // of the picture, right and up. unit: widths and heights of the picture

  /// Returns whether the camera fits the volume into the picture: it has no eye.
  bool framed() const { return !eye; }
  /// `turns` are the rotations of a turntable (frameVolume). throws: Error kUsage if settings contradict each other (an
  /// eye and a side; a height without a projection) or the camera cannot be used.
  Camera resolve(const FramedBox& box, const ImageSize& size, Turns turns = {}) const;
};

}  // namespace kiln
