// Classification: colour and extinction of a value, and whether a range of values contains a visible value (for the
// octree). Values of 8 and 16 bits take one table look-up, wider types a search for the segment. Both are exact.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <vector>

#include "grid/value_range.h"
#include "grid/voxel_type.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

struct Material {
  float r = 0, g = 0, b = 0;  // linear light
  float tau = 0;              // extinction. unit: 1 / world
};

class Classifier {
 public:
  /// `unit` is the length that opacities refer to. `range` bounds the values of later calls.
  Classifier(const TransferFunction& function, double unit, VoxelType type, const ValueRange& range);

  /// Material of a value. requires: `value` inside the range given to the constructor.
  template <class T>
  Material at(T value) const {
    if constexpr (sizeof(T) <= 2) {
      return table_[static_cast<std::size_t>(static_cast<int>(value) - first_)];
    } else {
      return evaluate(static_cast<double>(value));
    }
  }

  /// Returns a predicate that a loop may keep: the value's opacity is above zero; false for NaN. requires: values
  /// inside the constructor's range, or NaN; the classifier outlives the predicate.
  template <class T>
  auto shows() const {
    if constexpr (sizeof(T) <= 2) {
      return [shown = shown_.data(), first = first_](T value) { return shown[static_cast<int>(value) - first] != 0; };
    } else {
      return [this](T value) {
        if constexpr (std::is_floating_point_v<T>) {
          if (std::isnan(value)) return false;
        }
        return function_.interesting(static_cast<double>(value));
      };
    }
  }

  /// Interval of visible values, if a type has up to 16 bits and its visible values are contiguous.
  struct Interval {
    int lo, hi;
  };
  const std::optional<Interval>& shownInterval() const { return shown_interval_; }

  /// Returns true if a value of `range` may have an opacity above zero. Exact, except conservative at a step of the
  /// function. cost: a binary search over the function's points.
  bool interesting(const ValueRange& range) const;

  /// Returns true for label volumes, whose gradients are gradients of opacity.
  bool ofLabels() const { return !function_.labels.empty(); }
  float opacityOf(double label) const { return static_cast<float>(function_.at(label).opacity); }

 private:
  Material evaluate(double value) const;

  TransferFunction function_;
  double unit_;
  std::vector<std::size_t> opaque_points_before_;  // prefix sums: points with an opacity above zero
  int first_ = 0;
  std::vector<Material> table_;
  std::vector<std::uint8_t> shown_;  // visible entries of the table, small enough for the cache
  std::optional<Interval> shown_interval_;
};

}  // namespace kiln
