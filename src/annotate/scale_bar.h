// The bar that shows a length of the world.
#pragma once

#include <optional>
#include <string>

#include "annotate/drawing.h"

namespace kiln {

struct ScaleBar {
  double length = 1;     // unit: world
  double length_px = 1;  // at the camera's target
  std::string unit;      // of the world, or "units"
  std::string label;
};
/// Returns the bar of the length that the options give, else the longest bar of a round length that takes at most 22 %
/// of the picture's width.
ScaleBar scaleBarOf(const AnnotatedPicture& picture);
/// Returns the width between the margins at the camera's target if the bar is too long to be drawn. unit: world.
std::optional<double> widthBelowScaleBar(const AnnotatedPicture& picture);

}  // namespace kiln
