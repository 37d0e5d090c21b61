// A closed interval of voxel values, as stored in a node of the min-max octree.
#pragma once

#include <algorithm>
#include <limits>

namespace kiln {

/// [lo, hi]; empty (lo > hi) if the voxels are all NaN or there are none. A double holds every value of every voxel
/// type exactly.
struct ValueRange {
  double lo = std::numeric_limits<double>::infinity();
  double hi = -std::numeric_limits<double>::infinity();

  bool operator==(const ValueRange&) const = default;
  bool empty() const { return !(lo <= hi); }
  bool contains(const ValueRange& other) const { return other.empty() || (lo <= other.lo && other.hi <= hi); }
  /// Extends the range to a value; NaN changes nothing.
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
