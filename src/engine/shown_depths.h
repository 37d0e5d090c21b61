// Optical depths that transfer functions give to ranges of values, as upper bounds.
// Method. Values are numbered: the span of a function's points is cut into equal bins, each label is a bin, and
// between two surfaces is a bin. A table of maxima over runs of 1, 2, 4, ... bins answers for a range by two look-ups.
#pragma once

#include <span>
#include <vector>

#include "base/progress.h"
#include "grid/value_range.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

class ShownDepths {
 public:
  /// The most opaque of several functions counts. `mean_spacing`: of the volume, the default unit of opacities;
  /// `values`: all values of the volume. requires: at least one function; all show labels, or all surfaces, or none.
  ShownDepths(std::span<const TransferFunction> functions, double mean_spacing, const ValueRange& values,
              const Progress& progress);

  bool ofLabels() const { return kind_ == Kind::kLabels; }
  bool ofSurfaces() const { return kind_ == Kind::kSurfaces; }
  /// The number of a missing value (NaN).
  static constexpr int kNone = -1;
  int binOf(double value) const;
  /// Returns a bound of the depth along `length` through values between two numbers. requires: first <= last, neither
  /// is kNone. unit: of `length`: world.
  double depth(int first, int last, double length) const {
    if (kind_ == Kind::kSurfaces) return first < last ? greatest(first + 1, last) : 0;
    return greatest(first, last) * length;
  }
  /// Returns the same bound for values in a range; 0 for an empty range.
  double depth(const ValueRange& range, double length) const;

 private:
  enum class Kind { kPoints, kLabels, kSurfaces };
  void addPoints(std::span<const TransferFunction> functions, double mean_spacing, const ValueRange& values,
                 const Progress& progress);
  void addMaxima();
  float greatest(int first, int last) const;

  Kind kind_ = Kind::kPoints;
  double lo_ = 0, bins_per_value_ = 0, hi_ = 0;  // ends of the points, bins per value
  std::vector<double> values_;                   // labels or surfaces, sorted
  // Extinction of each bin, unit: 1 / world; for surfaces the depth of a crossing. [level][bin]: maximum of 2^level
  // bins from `bin` on.
  std::vector<std::vector<float>> maxima_;
};

}  // namespace kiln
