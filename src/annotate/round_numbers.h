// Numbers that readers expect on scales: 1, 2 or 5 times a power of ten.
#pragma once

#include <string>
#include <vector>

namespace kiln {

/// Returns the greatest such number that is not above `most`. requires: most > 0.
double roundNumberBelow(double most);

/// Returns the multiples of the least such number that leaves at most `most_ticks` of them in [lo, hi]. requires: lo <=
/// hi, most_ticks >= 2.
std::vector<double> roundTicks(double lo, double hi, int most_ticks);

/// Returns the text of a multiple of `step`, with the digits that tell it from its neighbours.
std::string textOfNumber(double value, double step);

}  // namespace kiln
