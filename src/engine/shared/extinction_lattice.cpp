#include "engine/shared/extinction_lattice.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/thread/parallel.h"

namespace kiln {

LatticeView turned(const LatticeView& lattice) {
  const View& from = lattice.view;
  LatticeView out = lattice;
  out.depth = from.size.width;
  out.view.size = {from.size.height, lattice.depth};
  glm::dmat4 turn(0.0);
  turn[1][0] = turn[2][1] = turn[0][2] = turn[3][3] = 1;
  turn[3][2] = from.centre_px.x / from.focal_px + lattice.near;
  out.view.view_from_world = turn * from.view_from_world;
  out.view.centre_px = {from.centre_px.y, -lattice.near * from.focal_px};
  const glm::dmat4 back = glm::inverse(out.view.view_from_world);
  out.view.eye_world = out.view.axis_world = back[3];
  out.view.forward_world = glm::normalize(glm::dvec3(back[2]));
  return out;
}

void ExtinctionLattice::turn() {
  if (open_.empty()) open_.assign(sums_.size(), 255);
  const auto slice = static_cast<std::size_t>(lattice_.cells().x * lattice_.cells().y);
  parallelFor(sums_.size() / slice, [&](std::size_t z) {
    for (std::size_t i = z * slice; i < (z + 1) * slice; ++i) {
      const int open = (255 * (kClosed - sums_[i]) + kClosed / 2) / kClosed;
      open_[i] = std::min(open_[i], static_cast<std::uint8_t>(open));
      sums_[i] = 0;
    }
  });
  ++turns_;
}

}  // namespace kiln
