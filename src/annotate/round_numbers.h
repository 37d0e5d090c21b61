// Numbers that readers expect on scales: 1, 2 or 5 times a power of ten.
#pragma once

#include <string>
#include <vector>

namespace kiln {

/// Returns the greatest such number that is not above `most`. requires: most > 0.
double roundNumberBelow(double most);

/// Returns the multiples in [lo, hi] of the least such number that has at most `most_ticks` multiples there. requires:
/// lo <= hi, most_ticks >= 2.
std::vector<double> roundTicks(double lo, double hi, int most_ticks);

/// Returns the text of a multiple of `step`, with the digits that distinguish neighbouring multiples.
std::string textOfNumber(double value, double step);

}  // namespace kiln
