// A box of voxels in view space, and where it is seen.
#pragma once

#include <glm/vec3.hpp>

#include "engine/shared/projector.h"
#include "image/pixel_rect.h"

namespace kiln {

/// unit: pixels of the image. Of nothing, x1 < x0.
struct ViewExtent {
  double x0 = kFar_px, y0 = kFar_px, x1 = -kFar_px, y1 = -kFar_px;
};

/// The cubes of a box's voxels. unit: world.
struct ViewBox {
  glm::dvec3 corner, edge[3];
  double nearest, farthest;  // along the view

  /// requires: `projector` outlives this.
  ViewBox(const Projector& projector, const VoxelBox& box);
  /// requires: in perspective nothing of it is behind the eye.
  ViewExtent extent() const;
  /// Of what lies in [near, far]. requires: perspective; near > 0.
  ViewExtent extentBetween(double near, double far) const;

 private:
  const Projector& projector_;
};

}  // namespace kiln
