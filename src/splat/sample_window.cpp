#include "splat/sample_window.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace kiln {
namespace {

// For rounding: of a sample's place in the picture, of its depth, and of its place in a unit.
constexpr double kPlaceSlack_px = 0.05, kDepthSlack_slabs = 0.1, kRoundingSlack = 1e-3;

}  // namespace

// A sample reaches the tile where its window touches it (refineUnit): its middle is then no farther than half of the
// other taps.
SampleWindow::SampleWindow(const UnitLattice& lattice, double sample_reach, const PixelRect& tile) : l_(lattice) {
  const double reach = 0.5 * (l_.taps - 1) + kPlaceSlack_px, focal = static_cast<double>(l_.focal);
  const auto side = [&](int axis, double sign, double edge_px, double centre_px) {
    glm::dvec3 along(0);
    along[axis] = sign * focal;
    const double beyond = reach + sign * (centre_px - edge_px);
    if (!l_.perspective) return Half{along, beyond};
    along.z = beyond;
    return Half{along, 0.0};
  };
  const double cx = static_cast<double>(l_.centre_x), cy = static_cast<double>(l_.centre_y);
  const double thickness = static_cast<double>(l_.thickness), near = static_cast<double>(l_.near);
  const double depth = (sample_reach + kDepthSlack_slabs) * thickness;
  double from = near - depth;
  if (l_.perspective) from = std::max(from, (1 - kRoundingSlack) * static_cast<double>(l_.near_depth));
  halves_ = {side(0, 1, tile.x0, cx),  side(0, -1, tile.x1, cx), side(1, 1, tile.y0, cy),
             side(1, -1, tile.y1, cy), Half{{0, 0, 1}, -from},   Half{{0, 0, -1}, near + l_.slabs * thickness + depth}};
}

bool SampleWindow::narrow(UnitInput& unit) const {
  // Twice, as what one leaves out along an axis tells the others more.
  for (int pass = 0; pass < 2; ++pass) {
    for (const Half& half : halves_) {
      if (!narrow(unit, half)) return false;
    }
  }
  return true;
}

bool SampleWindow::narrow(UnitInput& unit, const Half& half) const {
  const glm::vec3 steps[3] = {l_.step_x, l_.step_y, l_.step_z};
  double slope[3], most[3];  // a sample on, and of those that are left
  double sum = half.beyond + glm::dot(half.along, glm::dvec3(unit.origin));
  for (std::size_t a = 0; a < 3; ++a) {
    if (unit.first[a] >= unit.end[a]) return false;
    const double voxel = glm::dot(half.along, glm::dvec3(steps[a]));
    slope[a] = voxel * unit.axis[a]->step;
    sum += voxel * static_cast<double>(unit.axis[a]->offset[0]);
    most[a] = slope[a] * (slope[a] > 0 ? unit.end[a] - 1 : unit.first[a]);
    sum += most[a];
  }
  for (std::size_t a = 0; a < 3; ++a) {
    // Where the others are at their most: sample i is in the half where rest + slope i >= 0.
    const double rest = sum - most[a], least = kRoundingSlack * std::abs(slope[a]);
    if (slope[a] > 0) {
      const double first = std::ceil((-rest - least) / slope[a]);
      unit.first[a] = static_cast<int>(std::clamp(first, double(unit.first[a]), double(unit.end[a])));
    } else if (slope[a] < 0) {
      const double last = std::floor((-rest - least) / slope[a]);
      unit.end[a] = static_cast<int>(std::clamp(last + 1, double(unit.first[a]), double(unit.end[a])));
    } else if (rest < 0) {
      unit.end[a] = unit.first[a];
    }
    if (unit.first[a] >= unit.end[a]) return false;
  }
  return true;
}

}  // namespace kiln
