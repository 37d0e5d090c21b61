#include "base/number_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kiln {

std::string numberText(double number, double step) {
  constexpr double kFewest = 6, kMost = 17;  // 17 digits distinguish all doubles
  const auto placeOf = [](double of) { return std::floor(std::log10(std::abs(of))); };
  const double digits = placeOf(number) - placeOf(step) + 1;
  const bool known = step > 0 && std::isfinite(digits);
  return fmt::format("{:.{}g}", number, static_cast<int>(known ? std::clamp(digits, kFewest, kMost) : kFewest));
}

}  // namespace kiln
