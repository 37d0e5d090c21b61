// Colours for labels that nobody chose colours for.
#pragma once

#include <glm/vec3.hpp>

namespace kiln {

/// The colour of a label's number, linear light. Any two of 1 to 32 are at least 32 apart in CIELAB (dE*ab, 1976), any
/// two of 1 to 256 at least 13; larger numbers have the same colours, darker. requires: label >= 1.
glm::dvec3 paletteColor(double label);

}  // namespace kiln
