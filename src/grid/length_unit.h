// Units of length by the names that headers use.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace kiln {

/// Returns the unit's short name: "um" for "micrometer", "\u00B5m" and 30 further spellings; empty if the unit is
/// unknown.
std::string unitName(std::string_view unit);

/// Returns the unit as readers of a picture expect it: "µm" for "um", "Å" for "angstrom"; other texts as they are.
std::string shownUnit(std::string_view unit);

/// Units of `to` per unit of `from`, as a quotient of integers. Multiplying before dividing keeps powers of ten exact.
struct LengthRatio {
  double numerator = 1, denominator = 1;
  double of(double length) const { return length * numerator / denominator; }
  bool operator==(const LengthRatio&) const = default;
};
/// Returns nothing if a name is no known unit of length. Equal names are equal units, known or not.
std::optional<LengthRatio> lengthRatio(std::string_view from, std::string_view to);

}  // namespace kiln
