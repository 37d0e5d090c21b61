// How much of a sample is there that lies across a face: of the volume's end, or of what is cut off.
#pragma once

#include <algorithm>
#include <cmath>

namespace kiln {

/// `inside` is how far it reaches inside of the face, in its own length: less than 0 where it is all outside, more than
/// 1 where it is all inside. A part that comes from rounding is none.
inline double partInside(double inside) {
  constexpr double kSteps = 4096;
  return std::clamp(std::round(inside * kSteps) / kSteps, 0.0, 1.0);
}

}  // namespace kiln
