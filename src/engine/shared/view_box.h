// A box of voxels in view space and its bounding rectangle in the picture.
#pragma once

#include <glm/vec3.hpp>

#include "engine/shared/projector.h"
#include "image/pixel_rect.h"

namespace kiln {

/// Bounding rectangle. unit: pixels of the image. Empty: x1 < x0.
struct ViewExtent {
  double x0 = kFar_px, y0 = kFar_px, x1 = -kFar_px, y1 = -kFar_px;
};

/// Box around the cubes of all voxels of a VoxelBox. unit: world.
struct ViewBox {
  glm::dvec3 corner, edge[3];
  double nearest, farthest;  // depths along the view

  /// requires: `projector` outlives the box.
  ViewBox(const Projector& projector, const VoxelBox& box);
  /// Bounding rectangle of the whole box. requires: in perspective the box lies in front of the eye.
  ViewExtent extent() const;
  /// Bounding rectangle of the part with depths in [near, far]. requires: perspective; near > 0.
  ViewExtent extentBetween(double near, double far) const;

 private:
  const Projector& projector_;
};

}  // namespace kiln
