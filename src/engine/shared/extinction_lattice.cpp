#include "engine/shared/extinction_lattice.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

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

}  // namespace kiln
