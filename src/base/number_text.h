// Texts of numbers with enough digits to differ from their neighbours.
#pragma once

#include <string>

namespace kiln {

/// Returns the number with at least six digits, down to the decimal place of `step`, the distance to a neighbour.
std::string numberText(double number, double step);

}  // namespace kiln
