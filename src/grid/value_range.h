// A closed interval of voxel values: what a node of the min-max octree knows about what lies below it.
#pragma once

#include <algorithm>
#include <limits>

namespace kiln {

/// [lo, hi]; empty (lo > hi) where nothing but NaN, or nothing at all, lies below. Every voxel type but none beyond
/// 53 bits is held exactly by a double.
struct ValueRange {
  double lo = std::numeric_limits<double>::infinity();
  double hi = -std::numeric_limits<double>::infinity();

  bool operator==(const ValueRange&) const = default;
  bool empty() const { return !(lo <= hi); }
  bool contains(const ValueRange& other) const { return other.empty() || (lo <= other.lo && other.hi <= hi); }
  /// A NaN leaves the range as it is.
  void include(double value) {
    if (value < lo) lo = value;
    if (value > hi) hi = value;
  }
  void include(const ValueRange& other) {
    lo = std::min(lo, other.lo);
    hi = std::max(hi, other.hi);
  }
};

}  // namespace kiln
