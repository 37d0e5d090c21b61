// The bar that shows a length of the world.
#pragma once

#include <string>

#include "annotate/drawing.h"

namespace kiln {

struct ScaleBar {
  double length = 1;     // unit: world
  double length_px = 1;  // at the camera's target
  std::string label;
};
/// Returns the bar of the length that the options give, else the longest bar of a round length that takes at most 22 %
/// of the picture's width.
ScaleBar scaleBarOf(const AnnotatedPicture& picture);

}  // namespace kiln
