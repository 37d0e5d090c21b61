#include "engine/shared/extinction_lattice.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/thread/parallel.h"

namespace kiln {
namespace {

std::size_t raysOf(const LatticeView& lattice) {
  return static_cast<std::size_t>(lattice.view.size.width) * static_cast<std::size_t>(lattice.view.size.height);
}

}  // namespace

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
    : lattice_(lattice),
      drawn_(lattice),
      rays_(raysOf(lattice)),
      sums_(static_cast<std::size_t>(lattice.cells().count()), 0) {}

std::uint64_t ExtinctionLattice::bytesOf(const LatticeView& lattice) {
  const LatticeView once = turned(lattice), twice = turned(once);
  const std::size_t rays = std::max({raysOf(lattice), raysOf(once), raysOf(twice)});
  return static_cast<std::uint64_t>(lattice.cells().count()) * (sizeof(std::uint16_t) + sizeof(std::uint8_t)) +
         rays * sizeof(LastCell);
}

void ExtinctionLattice::turn() {
  const auto across = static_cast<std::size_t>(drawn_.view.size.width);
  for (std::size_t ray = 0; ray < rays_.size(); ++ray)
    end(static_cast<int>(ray % across), static_cast<int>(ray / across), rays_[ray]);
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
  drawn_ = turned(drawn_);
  rays_.assign(raysOf(drawn_), {});
}

}  // namespace kiln
