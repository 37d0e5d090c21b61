// The edges of the clipped box of a volume.
#pragma once

#include <vector>

#include "grid/geometry.h"
#include "scene/clipping.h"
#include "scene/half_spaces.h"

namespace kiln {

/// Returns the edges of the volume's box in the world, cut by the region and the planes; none if nothing is left. Each
/// edge is listed once.
std::vector<Edge> edgesOf(const VolumeGeometry& volume, const Clipping& clipping);

}  // namespace kiln
