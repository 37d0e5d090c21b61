// Depth of field. A picture through a lens is the mean of pictures from points of the lens, which agree at the focus
// (Cook, Porter and Carpenter, "Distributed Ray Tracing", 1984; by whole views, Haeberli and Akeley, "The Accumulation
// Buffer", 1990).
#pragma once

#include <vector>

#include "scene/camera/camera_spec.h"

namespace kiln {

/// Returns the view from an eye moved by `offset` in view space (right, down). Points at `depth` keep their pixels.
/// unit: world. requires: perspective.
View fromMovedEye(View view, const glm::dvec2& offset, double depth);

/// Returns the views from the points of a lens, which fill the disc evenly; the first is next to the middle. Returns
/// nothing for an aperture of 0. throws: Error kUsage for a camera without perspective.
std::vector<View> viewsThrough(const Lens& lens, const View& view, const Camera& camera);

}  // namespace kiln
