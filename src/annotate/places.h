// Places of annotations: each annotation takes a rectangle that no other annotation covers.
// Method. Text has the upper left corner, directions the lower left and the scale bar the lower right. Directions stand
// above the scale bar where the picture is narrow. The legend has what remains of its side.
// Invariant. Places depend on the options, the size of the picture and the texts, not on the volume: in a film nothing
// jumps.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "annotate/drawing.h"

namespace kiln {

/// Gap between annotations, and beside a legend. unit: the font's size.
inline constexpr double kApart = 0.6;

/// Room in the picture. unit: pixels.
struct Room {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool empty() const { return x0 >= x1 || y0 >= y1; }
};

/// Returns the text, or its longest beginning that is not wider than `width`, with "…". unit: pixels.
std::string cutToWidth(std::string_view utf8, double size, double width);

/// Lines of the text in the corner as they fit: smaller than other text by at most a half, then cut.
struct CornerText {
  std::vector<std::string> lines;
  double size = 0;  // size of the font. unit: pixels
  Room room;
};
CornerText cornerText(const AnnotatedPicture& picture, const Style& style);

/// Rooms of the scale bar with its label, and of the directions; empty if they are not drawn.
Room scaleBarRoom(const AnnotatedPicture& picture, const Style& style);
Room directionsRoom(const AnnotatedPicture& picture, const Style& style);

/// Returns the room of the directions, drawn or not.
Room placeOfDirections(const AnnotatedPicture& picture, const Style& style);

/// Returns the room for a legend of this width at its side of the picture.
Room legendRoom(const AnnotatedPicture& picture, const Style& style, double width);

/// The legend's place as given, or chosen by the shape of the picture.
LegendPlace legendPlaceOf(const AnnotatedPicture& picture);
bool standsLeft(LegendPlace place);

}  // namespace kiln
