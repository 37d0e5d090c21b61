// Colour spaces for interpolating colour maps, with VTK's constants, so that a map looks as in VTK. Source: VTK,
// vtkMath and vtkColorTransferFunction; Moreland 2009 for Msh (a polar CIELAB with white in the middle).
#pragma once

#include <glm/vec3.hpp>

namespace kiln {

/// kHsvWrapped is kHsv with hues interpolated the shorter way round, over red if that is shorter.
enum class ColorSpace { kRgb, kHsv, kHsvWrapped, kLab, kDiverging, kStep };

/// Interpolates from `a` (s = 0) to `b` (s = 1); all colours are sRGB display values, 0..1. kDiverging passes through
/// white between two strong hues. kStep is `b` for every s above 0.
glm::dvec3 interpolated(ColorSpace space, const glm::dvec3& a, const glm::dvec3& b, double s);

}  // namespace kiln
