// Convex bodies as intersections of half-spaces: points p with normal·p + w >= 0, normal the first three numbers.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <utility>
#include <vector>

#include "grid/coords.h"

namespace kiln {

/// Begin and end.
using Edge = std::pair<glm::dvec3, glm::dvec3>;

/// Appends the half-spaces of a box whose sides are parallel to the axes.
void addBox(const glm::dvec3& lo, const glm::dvec3& hi, std::vector<glm::dvec4>& half_spaces);

/// Returns a half-space of the world in an index space, with a normal of length 1.
glm::dvec4 inIndexSpace(const glm::dvec4& half_space, const glm::dmat4& world_from_index);

/// Returns whether a half-space of index space hides a part of a volume's box. A plane in the border hides nothing.
bool cuts(const glm::dvec4& half_space, const Extent3& dims);

/// Returns the edges in which two planes meet, as far as the other half-spaces leave an edge; an edge of more than two
/// planes several times. requires: normals of length 1.
std::vector<Edge> edgesOf(std::span<const glm::dvec4> half_spaces);

}  // namespace kiln
