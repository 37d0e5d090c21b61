// Points around what a picture shows: a camera that contains the points contains everything between them.
// Problem. A box has corners where nothing is: seen aslant, a head fills two thirds of a picture that fits its box.
// Method. The corners that reach farthest in each of kOutlineDirections directions, evenly over the sphere.
// Invariant. What reaches beyond the points is less than 0.5 % of half the extent: for a ball, 1 - cos(5.6°), the
// greatest angle from a direction to the nearest of the set. Margins of fitted cameras are larger.
// Source: Klosowski et al. 1998 (discrete orientation polytopes); Swinbank and Purser 2006 (even directions).
// Differs: points instead of planes, so that turns and perspectives of the points need no intersections.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "grid/coords.h"
#include "grid/geometry.h"

namespace kiln {

inline constexpr int kOutlineDirections = 512;

/// Returns at most kOutlineDirections corners of the boxes' voxels, each once. requires: no empty box. unit: world.
std::vector<glm::dvec3> outlineOf(const std::vector<VoxelBox>& boxes, const VolumeGeometry& volume);

}  // namespace kiln
