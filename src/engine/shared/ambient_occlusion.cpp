#include "engine/shared/ambient_occlusion.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace kiln {

AmbientLookup::AmbientLookup(const AmbientGrid& grid, float strength, const glm::dmat4& view_from_world)
    : grid_(&grid), strength_(strength) {
  const glm::dmat4 grid_from_view = grid.gridFromWorld() * glm::inverse(view_from_world);
  grid_from_view_ = glm::mat4(grid_from_view);
  for (int axis = 0; axis < 3; ++axis) turned_[axis] = glm::vec3(glm::normalize(glm::dvec3(grid_from_view[axis])));
}

float AmbientLookup::share(const glm::vec3& view_point, const glm::vec3& normal) const {
  const glm::vec3 turned = turned_ * normal;
  const glm::vec3 at = glm::vec3(grid_from_view_ * glm::vec4(view_point, 1)) + kAhead * turned;
  const Extent3& n = grid_->dims();
  int cell[3];
  float part[3];
  for (int axis = 0; axis < 3; ++axis) {
    const auto last = static_cast<float>(n[axis] - 1);
    const float inside = std::clamp(at[axis], 0.0f, last);
    cell[axis] = std::min(static_cast<int>(inside), static_cast<int>(n[axis]) - 2);
    part[axis] = inside - static_cast<float>(cell[axis]);
  }
  float mean = 0, along = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
    const AmbientCell& c = grid_->cells()[((cell[2] + dz) * n.y + cell[1] + dy) * n.x + cell[0] + dx];
    const float weight =
        (dx != 0 ? part[0] : 1 - part[0]) * (dy != 0 ? part[1] : 1 - part[1]) * (dz != 0 ? part[2] : 1 - part[2]);
    mean += weight * static_cast<float>(c.mean + AmbientCell::kHalfOpen);
    along += weight * (static_cast<float>(c.along[0]) * turned.x + static_cast<float>(c.along[1]) * turned.y +
                       static_cast<float>(c.along[2]) * turned.z);
  }
  const float seen = mean * AmbientCell::kMean + 2 * AmbientCell::kAlong * along;
  return 1 - strength_ * (1 - std::clamp(seen, 0.0f, 1.0f));
}

}  // namespace kiln
