// Classification as the kernel asks for it: colour and extinction of a value, by one table look-up for 8 and 16 bits
// and by segment for wider types; and whether a range of values holds anything at all, for the octree. Both are exact.
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
  /// `unit` is the length that opacities are per. `range` bounds the values that will be asked for.
  Classifier(const TransferFunction& function, double unit, VoxelType type, const ValueRange& range);

  /// requires: `value` inside the range given.
  template <class T>
  Material at(T value) const {
    if constexpr (sizeof(T) <= 2) {
      return table_[static_cast<std::size_t>(static_cast<int>(value) - first_)];
    } else {
      return evaluate(static_cast<double>(value));
    }
  }

  /// Whether a value has an opacity above zero, which NaN has not, as a function that a loop may keep. requires: values
  /// inside the range given, or NaN; that this outlives it.
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

  /// The values of types of up to 16 bits that show something, where all between two do and no other.
  struct Interval {
    int lo, hi;
  };
  const std::optional<Interval>& shownInterval() const { return shown_interval_; }

  /// Whether some value of the range may have an opacity above zero. Conservative only at a step of the function.
  /// cost: a binary search over the function's points.
  bool interesting(const ValueRange& range) const;

  /// Whether values are labels, whose gradients are of their opacities.
  bool ofLabels() const { return !function_.labels.empty(); }
  float opacityOf(double label) const { return static_cast<float>(function_.at(label).opacity); }

 private:
  Material evaluate(double value) const;

  TransferFunction function_;
  double unit_;
  std::vector<std::size_t> opaque_points_before_;  // prefix sums of points with an opacity above zero
  int first_ = 0;
  std::vector<Material> table_;
  std::vector<std::uint8_t> shown_;  // of the table's entries: what fits a cache where those do not
  std::optional<Interval> shown_interval_;
};

}  // namespace kiln
