// Default cameras: from a side, turned, and fitted to the volume.
#pragma once

#include <optional>
#include <vector>

#include "grid/geometry.h"
#include "scene/camera/camera.h"

namespace kiln {

enum class Side { kFront, kBack, kLeft, kRight, kTop, kBottom };

struct Framing {
  /// Front is the patient's face; in a volume without a frame, the side towards -y with +z up (as in LPS).
  Side side = Side::kFront;
  /// Turns the eye about the up axis (positive: to the patient's left, seen from the front), then raises it. unit:
  /// degrees; elevation from -90 to 90.
  double azimuth_deg = 0, elevation_deg = 0;
  /// 1 fits the volume's box into the image with a small margin; 2 is twice as large.
  double zoom = 1;
  Projection projection = Projection::kPerspective;
  double fov_deg = 30;
};

/// Default framing: three quarters from the front, slightly from above.
Framing defaultFraming();

/// World directions of a patient in a frame; an unknown frame is read as LPS. Unit length.
struct PatientAxes {
  glm::dvec3 left, anterior, superior;
};
PatientAxes patientAxes(PatientFrame frame);

/// Returns a camera whose image of size `size` contains the volume's box; the eye is always outside the box. Zoom
/// narrows the field of view (or height) and leaves the eye, so the perspective is unchanged.
/// throws: Error kUsage if zoom is not positive, or an angle is out of range.
Camera frameVolume(const VolumeGeometry& volume, const Framing& framing, const ImageSize& size);

/// Returns the orthographic height at which the image of `camera` (eye, target and up) contains the volume's box, with
/// the margin of `frameVolume`. unit: world.
double fittingHeight(const VolumeGeometry& volume, const Camera& camera, const ImageSize& size);

/// Returns a box in the axes of the first volume that contains the boxes of all volumes; the first volume's own box if
/// that is enough. shape: whole voxels of the first volume. requires: at least one volume.
VolumeGeometry boxAround(const std::vector<VolumeGeometry>& volumes);

/// Returns the middle of the volume's box. unit: world.
glm::dvec3 centreOf(const VolumeGeometry& volume);

}  // namespace kiln
