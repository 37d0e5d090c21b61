// Default colours of labels.
#pragma once

#include <glm/vec3.hpp>

namespace kiln {

/// Returns the colour of a label number, linear light. Any two of the labels 1 to 32 are at least 32 apart in CIELAB
/// (dE*ab, 1976), any two of 1 to 256 at least 13. Larger numbers repeat the colours, darker. requires: label >= 1.
glm::dvec3 paletteColor(double label);

}  // namespace kiln
