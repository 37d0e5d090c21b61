// A camera for people who name none: from a side, turned, and fitted to the volume.
#pragma once

#include <optional>
#include <vector>

#include "grid/geometry.h"
#include "scene/camera/camera.h"

namespace kiln {

enum class Side { kFront, kBack, kLeft, kRight, kTop, kBottom };

struct Framing {
  /// Front means the patient's face; of a volume without a frame, the side towards -y with +z up (as LPS has it).
  Side side = Side::kFront;
  /// Turns the eye about the up axis (to the patient's left for positive angles seen from the front), then raises it.
  /// unit: degrees; elevation from -90 to 90.
  double azimuth_deg = 0, elevation_deg = 0;
  /// 1 fits the volume's box into the image with a small margin; 2 is twice as large.
  double zoom = 1;
  Projection projection = Projection::kPerspective;
  double fov_deg = 30;
};

/// What a picture shows where nobody says: three quarters from the front, a little from above.
Framing defaultFraming();

/// World directions of a patient, by the frame; an unknown frame is read as LPS. Unit length.
struct PatientAxes {
  glm::dvec3 left, anterior, superior;
};
PatientAxes patientAxes(PatientFrame frame);

/// The camera whose image of size `size` holds the volume's box, eye always outside of it. Zoom narrows the field of
/// view (or height) about the centre and leaves the eye, so that the perspective stays.
/// throws: Error kUsage where zoom is not positive, or an angle is out of range.
Camera frameVolume(const VolumeGeometry& volume, const Framing& framing, const ImageSize& size);

/// The orthographic height at which `camera` (eye, target and up) has the volume's box in its image, with the margin
/// of `frameVolume`. unit: world.
double fittingHeight(const VolumeGeometry& volume, const Camera& camera, const ImageSize& size);

/// A box in the axes of the first volume that holds the boxes of all: the first's own where it holds them. shape: its
/// voxels are the first's, whole ones. requires: at least one.
VolumeGeometry boxAround(const std::vector<VolumeGeometry>& volumes);

/// The middle of the volume's box. unit: world.
glm::dvec3 centreOf(const VolumeGeometry& volume);

}  // namespace kiln
