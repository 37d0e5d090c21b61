// The legend of a transfer function: a bar of colours with numbers, or a square for each surface or label.
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "annotate/drawing.h"

namespace kiln {

/// The bar of colours. shape: whole pixels; the greatest value is at the top.
struct ColorBar {
  double lo = 0, hi = 1;  // values at the bottom and at the top
  PixelRect at;
  std::vector<double> ticks;
  /// Returns the value in the middle of a row of pixels, and the height of a value. unit: pixels.
  double valueOfRow(int row) const { return hi - (row + 0.5 - at.y0) / at.height() * (hi - lo); }
  double heightOf(double value) const { return at.y0 + (hi - value) / (hi - lo) * at.height(); }
};
/// requires: a function of points.
ColorBar colorBarOf(const AnnotatedPicture& picture, const Style& style);

/// An entry of a legend of surfaces or labels.
struct LegendEntry {
  glm::dvec3 color;  // linear light; negative: an entry without a colour
  std::string text;
};
/// Returns the visible surfaces, the greatest value first, or the visible labels; empty for a function of points. A
/// list longer than kMostEntries ends in an entry that counts the rest.
std::vector<LegendEntry> legendEntries(const TransferFunction& function);
inline constexpr std::size_t kMostEntries = 14;

}  // namespace kiln
