// The values of an exported OpenVDB grid: exact, or rounded and sparse.
#pragma once

#include <optional>

namespace kiln {

/// The numbers of a grid: the store's numbers, or floats of 32 or 16 bits.
enum class VdbType { kExact, kFloat, kHalf };

/// The values of a grid.
struct VdbValues {
  VdbType type = VdbType::kExact;
  /// The value of inactive space; by default the store's background.
  std::optional<double> background = {};
  /// Values that differ from the background by so much become background.
  double tolerance = 0;
};

}  // namespace kiln
