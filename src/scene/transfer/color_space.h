// Colour spaces in which programs interpolate colour maps, with VTK's numbers, so that a map looks here as it does
// there. Source: VTK, vtkMath and vtkColorTransferFunction; K. Moreland, Diverging Color Maps for Scientific
// Visualization, 2009, for Msh (a polar CIELAB whose middle is white).
#pragma once

#include <glm/vec3.hpp>

namespace kiln {

/// kHsvWrapped is kHsv with hues that take the shorter way round, over red where that is shorter.
enum class ColorSpace { kRgb, kHsv, kHsvWrapped, kLab, kDiverging, kStep };

/// From `a` (s = 0) to `b` (s = 1); they and the result are sRGB as displays show it, 0..1. Between two strong hues
/// kDiverging passes through white. kStep is `b` from the first s above 0 on.
glm::dvec3 interpolated(ColorSpace space, const glm::dvec3& a, const glm::dvec3& b, double s);

}  // namespace kiln
