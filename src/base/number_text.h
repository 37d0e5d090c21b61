// Texts of numbers whose neighbours a reader has to tell apart.
#pragma once

#include <string>

namespace kiln {

/// Returns the number with six digits, or with as many more as the digits of `step`, a difference from its neighbours,
/// need.
std::string numberText(double number, double step);

}  // namespace kiln
