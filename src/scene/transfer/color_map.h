// Colour maps and opacity curves as other programs have them, and their way into a transfer function: that is linear in
// linear light between its points, they are not, so they are sampled finely enough that nobody sees the difference.
#pragma once

#include <vector>

#include "grid/value_range.h"
#include "scene/transfer/color_space.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

struct ColorNode {
  double value = 0;
  glm::dvec3 srgb{0};  // as displays show it, 0..1
};

/// Colours at nodes, and how to get from one to the next; the end nodes hold outside. requires: sorted by value, one at
/// least.
struct ColorMap {
  ColorSpace space = ColorSpace::kRgb;
  std::vector<ColorNode> nodes;
  /// sRGB.
  glm::dvec3 at(double value) const;
};

struct OpacityNode {
  double value = 0, opacity = 0;
  /// Of the way to the next node: where half of it is gone, 0..1; and from a straight line (0) to a step there (1).
  double midpoint = 0.5, sharpness = 0;
};

/// vtkPiecewiseFunction: a node's midpoint and sharpness shape the curve to the next. requires: as ColorMap.
struct OpacityCurve {
  std::vector<OpacityNode> nodes;
  double at(double value) const;
};

/// How far a sampled map is from itself at most: half a step of an 8-bit picture in colour as displays show it, and a
/// thousandth in opacity.
inline constexpr double kSampledColorError = 0.5 / 255;
inline constexpr double kSampledOpacityError = 1e-3;

/// The points of the transfer function with these colours and opacities, within the errors above.
std::vector<TransferPoint> sampled(const ColorMap& colors, const OpacityCurve& opacity);

/// The same with all values moved linearly, `from` onto `to`. requires: from.lo < from.hi.
void stretch(ColorMap& colors, const ValueRange& from, const ValueRange& to);
void stretch(OpacityCurve& opacity, const ValueRange& from, const ValueRange& to);
void stretch(std::vector<TransferPoint>& points, const ValueRange& from, const ValueRange& to);

}  // namespace kiln
