// A camera for people who name none: from a side, turned, and fitted to the volume.
#pragma once

#include <optional>

#include "grid/geometry.h"
#include "scene/camera.h"

namespace kiln {

enum class Side { kFront, kBack, kLeft, kRight, kTop, kBottom };

struct Framing {
  /// Front means the patient's face; of a volume without a frame, the side towards -y with +z up (as LPS has it).
  Side side = Side::kFront;
  /// Turns the eye about the up axis (to the patient's left for positive angles seen from the front), then raises it.
  double azimuth_deg = 0, elevation_deg = 0;
  /// 1 fits the volume's box into the image with a small margin; 2 is twice as large.
  double zoom = 1;
  Projection projection = Projection::kPerspective;
  double fov_deg = 30;
};

/// What a picture shows where nobody says: three quarters from the front, a little from above.
Framing defaultFraming();

/// The camera whose image of size `size` holds the volume's box. throws: Error kUsage where zoom is not positive.
Camera frameVolume(const VolumeGeometry& volume, const Framing& framing, const ImageSize& size);

}  // namespace kiln
