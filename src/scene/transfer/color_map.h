// Colour maps and opacity curves of other programs, and their conversion to a transfer function. A transfer function is
// linear in linear light between points, the maps are not; they are sampled until the difference is invisible.
#pragma once

#include <vector>

#include "grid/value_range.h"
#include "grid/volume_info.h"
#include "scene/transfer/color_space.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

struct ColorNode {
  double value = 0;
  glm::dvec3 srgb{0};  // display values, 0..1
};

/// Returns the display values of a colour, without its opacity.
inline glm::dvec3 srgbOf(const DisplayColor& color) { return glm::dvec3(color.red, color.green, color.blue) / 255.0; }

/// Colours at nodes with an interpolation rule; the end nodes extend outside. requires: sorted by value, at least one
/// node.
struct ColorMap {
  ColorSpace space = ColorSpace::kRgb;
  std::vector<ColorNode> nodes;
  /// Returns display values (sRGB).
  glm::dvec3 at(double value) const;
};

struct OpacityNode {
  double value = 0, opacity = 0;
  /// Shape of the curve to the next node: `midpoint` is the position of half the change, 0..1; `sharpness` runs from a
  /// straight line (0) to a step at the midpoint (1).
  double midpoint = 0.5, sharpness = 0;
};

/// As vtkPiecewiseFunction: a node's midpoint and sharpness shape the curve to the next node. requires: as ColorMap.
struct OpacityCurve {
  std::vector<OpacityNode> nodes;
  double at(double value) const;
};

/// Upper bounds for the error of a sampled map: half a step of an 8-bit picture in display values, and a thousandth in
/// opacity.
inline constexpr double kSampledColorError = 0.5 / 255;
inline constexpr double kSampledOpacityError = 1e-3;

/// Returns the points of a transfer function with these colours and opacities, within the errors above.
std::vector<TransferPoint> sampled(const ColorMap& colors, const OpacityCurve& opacity);

/// Maps all values linearly from `from` onto `to`. requires: from.lo < from.hi.
void stretch(ColorMap& colors, const ValueRange& from, const ValueRange& to);
void stretch(OpacityCurve& opacity, const ValueRange& from, const ValueRange& to);
void stretch(std::vector<TransferPoint>& points, const ValueRange& from, const ValueRange& to);
void stretch(std::vector<IsoSurface>& surfaces, const ValueRange& from, const ValueRange& to);

}  // namespace kiln
