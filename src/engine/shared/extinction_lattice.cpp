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

ExtinctionLattice::ExtinctionLattice(const LatticeView& lattice)
    : lattice_(lattice), sums_(static_cast<std::size_t>(lattice.cells().count()), 0) {
  beginView();
}

// A turned view has the rays of another side.
std::uint64_t ExtinctionLattice::bytesOf(const LatticeView& lattice) {
  const std::int64_t edges[3] = {lattice.view.size.width, lattice.view.size.height, lattice.depth};
  const std::int64_t rays = std::max({edges[0] * edges[1], edges[1] * edges[2], edges[2] * edges[0]});
  return static_cast<std::uint64_t>(lattice.cells().count()) * (sizeof(std::uint16_t) + sizeof(std::uint8_t)) +
         static_cast<std::uint64_t>(rays) * sizeof(LastCell);
}

void ExtinctionLattice::beginView() {
  const std::int64_t edges[3] = {lattice_.view.size.width, lattice_.view.size.height, lattice_.depth};
  rays_across_ = static_cast<std::size_t>(edges[turns_ % 3]);
  const Extent3 n = lattice_.cells();
  cells_along_ = static_cast<int>((turns_ % 3 == 0 ? n.z : turns_ % 3 == 1 ? n.x : n.y));
  rays_.assign(rays_across_ * static_cast<std::size_t>(edges[(turns_ + 1) % 3]), {});
}

void ExtinctionLattice::turn() {
  for (std::size_t ray = 0; ray < rays_.size(); ++ray)
    end(static_cast<int>(ray % rays_across_), static_cast<int>(ray / rays_across_), rays_[ray]);
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
  beginView();
}

}  // namespace kiln
