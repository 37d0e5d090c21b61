#include "grid/pyramid.h"

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <limits>

namespace kiln {

Extent3 halvingOf(const VolumeGeometry& fine) {
  const glm::dvec3 spacing = fine.spacing();
  double smallest = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (fine.dims[axis] > 1) smallest = std::min(smallest, spacing[axis]);
  }
  const auto factor = [&](int axis) -> std::int64_t {
    return fine.dims[axis] > 1 && spacing[axis] < std::sqrt(2.0) * smallest ? 2 : 1;
  };
  return {factor(0), factor(1), factor(2)};
}

VolumeGeometry coarserThan(const VolumeGeometry& fine) {
  const Extent3 by = halvingOf(fine);
  const glm::dvec3 factors(by.x, by.y, by.z);
  VolumeGeometry coarse = fine;
  coarse.dims = coarseBox(boxOf(fine.dims), by).extent();
  coarse.world_from_index = glm::scale(glm::translate(fine.world_from_index, (factors - 1.0) / 2.0), factors);
  return coarse;
}

std::vector<VolumeGeometry> pyramidOf(const VolumeGeometry& finest, std::int64_t brick_size, int most_levels) {
  std::vector<VolumeGeometry> levels = {finest};
  while (static_cast<int>(levels.size()) < most_levels && brickLattice(levels.back().dims, brick_size).count() > 1)
    levels.push_back(coarserThan(levels.back()));
  return levels;
}

}  // namespace kiln
