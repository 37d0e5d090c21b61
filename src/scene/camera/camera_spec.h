// A camera as people say it: in part.
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "grid/geometry.h"
#include "scene/camera/camera.h"
#include "scene/camera/framing.h"

namespace kiln {

/// A camera said in part: either where the eye is, or a framing, each key optional. With an eye, the target is the
/// volume's centre, up is superior, fov 60 and an orthographic height the fitting one where nothing is said. Without,
/// it is `defaultFraming`, or a side seen straight; a target then moves eye and target together. Where the projection
/// is named, the other projection's fov or height is passed over.
struct CameraSpec {
  std::optional<Projection> projection;
  std::optional<glm::dvec3> eye, target, up;
  std::optional<double> fov_deg, height;
  std::optional<Side> side;
  std::optional<double> azimuth_deg, elevation_deg, zoom;

  /// throws: Error kUsage where the parts contradict each other (an eye and a side; a height and no projection) or the
  /// camera cannot be used.
  Camera resolve(const VolumeGeometry& volume, const ImageSize& size) const;
};

}  // namespace kiln
