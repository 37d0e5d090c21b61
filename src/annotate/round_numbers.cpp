#include "annotate/round_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kiln {
namespace {

// digit · 10^exponent, of the nearest double.
double decimal(int digit, int exponent) {
  return exponent < 0 ? digit / std::pow(10.0, -exponent) : digit * std::pow(10.0, exponent);
}

}  // namespace

double roundNumberBelow(double most) {
  const int exponent = static_cast<int>(std::floor(std::log10(most)));
  // The logarithm may be off by a rounding error.
  for (int e = exponent + 1;; --e) {
    for (const int digit : {5, 2, 1}) {
      if (const double number = decimal(digit, e); number <= most) return number;
    }
  }
}

std::vector<double> roundTicks(double lo, double hi, int most_ticks) {
  if (!(lo < hi)) return {lo};
  std::vector<double> out;
  const int exponent = static_cast<int>(std::floor(std::log10((hi - lo) / most_ticks)));
  for (int e = exponent;; ++e) {
    for (const int digit : {1, 2, 5}) {
      const double step = decimal(digit, e), slack = 1e-9 * (hi - lo);
      const double first = std::ceil((lo - slack) / step), last = std::floor((hi + slack) / step);
      if (last - first + 1 > most_ticks) continue;
      for (int i = 0; i <= last - first; ++i) {
        const double n = first + i;
        const double tick = n == 0 ? 0 : e < 0 ? n * digit / std::pow(10.0, -e) : n * step;
        if (out.empty() || out.back() < tick) out.push_back(tick);
      }
      return out;
    }
  }
}

std::string textOfNumber(double value, double step) {
  const double size = std::max(std::abs(value), step);
  std::string out;
  if (size >= 1e6 || (size > 0 && size < 1e-4)) {
    // A double has up to 17 digits.
    const double digits =
        value == 0 ? 1 : std::floor(std::log10(size) + 1e-9) - std::floor(std::log10(step) + 1e-9) + 1;
    out = fmt::format("{:.{}g}", value, std::clamp(static_cast<int>(digits), 1, 17));
  } else {
    out = fmt::format("{:.{}f}", value, std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9))));
  }
  if (out.starts_with('-')) out.replace(0, 1, "\xe2\x88\x92");  // a minus sign
  return out;
}

}  // namespace kiln
