// Units of length by the names that headers use.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace kiln {

/// Returns the unit's short name: "um" for "micrometer", "\u00B5m" and 30 further spellings; empty if the unit is
/// unknown.
std::string unitName(std::string_view unit);

/// A quotient of two units. Multiplying before dividing keeps powers of ten exact.
struct UnitRatio {
  double numerator = 1, denominator = 1;
  double of(double length) const { return length * numerator / denominator; }
};
/// Returns the number of `to` in one `from`; nothing if they differ and either is unknown.
std::optional<UnitRatio> unitRatio(std::string_view from, std::string_view to);

}  // namespace kiln
