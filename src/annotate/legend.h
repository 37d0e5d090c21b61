// The legends of transfer functions, one below the other: a bar of colours with numbers, or squares for surfaces,
// labels and regions.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "annotate/drawing.h"
#include "scene/camera/framing.h"

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

/// An entry of a legend of surfaces, labels or regions.
struct LegendEntry {
  glm::dvec3 color;  // linear light; negative: an entry without a colour
  std::string text;
};

/// A bar, or squares, in their place.
struct LegendPart {
  const ShownFunction* shown = nullptr;   // null: the entry counts parts that found no room
  std::string title;                      // above; empty: none
  std::vector<LegendEntry> entries = {};  // empty: a bar
  ColorBar bar = {};
  PixelRect first_square = {};       // square of the first entry
  std::size_t rows = 0;              // entries of a column
  std::vector<double> columns = {};  // beginnings of columns of entries, from the first. unit: pixels
  double width = 0;                  // with all texts. unit: pixels
};

/// Returns the parts of the legend from top to bottom: of each function its bar, its surfaces, its labels, and regions
/// that have colours of their own. Where room is short, bars are shorter, lists have several columns if these take at
/// most kMostOfWidth of the picture's width, and then end earlier. requires: the picture outlives the result.
std::vector<LegendPart> legendParts(const AnnotatedPicture& picture, const Style& style);

/// Returns choices of edges of the picture that hold the legend: the columns at its side, and for a legend in a corner
/// the rows above or below. Empty without a legend. Edges do not depend on the camera: the view and a given length of
/// the scale bar are ignored.
std::vector<FreeEdges> legendEdges(AnnotatedPicture picture);
/// Least share of the picture's width or height that edges leave. An object of less than half of its size would be lost
/// for its legend: legends of more width lie over the object.
inline constexpr double kLeastBeside = 0.5;

/// Returns the visible surfaces, the greatest value first, the visible labels that the volume has, or the colours of
/// regions; empty for other functions. A list longer than `most` ends in an entry that counts the rest.
std::vector<LegendEntry> legendEntries(const ShownFunction& shown, std::size_t most);
/// Most entries of a list in any picture: their texts are measured.
inline constexpr std::size_t kMostEntries = 500;
/// Share of the picture's width beyond which a legend has no further column, texts are cut, and titles have no room of
/// their own.
inline constexpr double kMostOfWidth = 0.3;

}  // namespace kiln
