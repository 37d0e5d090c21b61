// The edges of the clipped box of a volume.
#pragma once

#include <glm/vec3.hpp>
#include <utility>
#include <vector>

#include "grid/geometry.h"
#include "scene/clipping.h"

namespace kiln {

using WorldLine = std::pair<glm::dvec3, glm::dvec3>;

/// Returns the edges of the volume's box, cut by the region and the planes; none if nothing is left. Each edge is
/// listed once.
std::vector<WorldLine> edgesOf(const VolumeGeometry& volume, const Clipping& clipping);

}  // namespace kiln
