// Closed polygons of a drawing, and the shapes that lines become.
#pragma once

#include <glm/vec2.hpp>
#include <string>
#include <vector>

namespace kiln {

/// A closed polygon. shape: corners in order, the last joined to the first. unit: pixels of the whole picture, y down.
using Contour = std::vector<glm::dvec2>;
/// Polygons that are filled together: a place is inside if the polygons wind around it (nonzero rule).
using Outline = std::vector<Contour>;

/// Appends the contours of `more`.
void append(Outline& outline, const Outline& more);

Contour rectangle(const glm::dvec2& lo, const glm::dvec2& hi);
/// Returns a regular polygon with so many corners.
Contour disc(const glm::dvec2& centre, double radius, int corners);
/// Returns the line from a to b as a rectangle; nothing for a line without length.
Outline stroke(const glm::dvec2& a, const glm::dvec2& b, double width);
/// Returns an arrow from a to b with a head of this length and width.
Outline arrow(const glm::dvec2& a, const glm::dvec2& b, double width, double head_length, double head_width);
/// Returns the outline and all places within `distance` of it.
Outline grown(const Outline& outline, double distance);

}  // namespace kiln
