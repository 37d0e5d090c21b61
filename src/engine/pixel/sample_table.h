// Classification of interpolated values: colour and extinction by one table over the volume's values, linear between
// its entries. What it says of a range is exact for what it says of values. Of labels it has two entries each, of those
// that are shown: nothing of it, and all.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "engine/shared/classifier.h"
#include "grid/value_range.h"

namespace kiln {

class SampleTable {
 public:
  /// `range` bounds the values that will be asked for; whole-numbered types of up to 16 bits have an entry a value,
  /// others as many as fit over classifiedRange.
  SampleTable(const TransferFunction& function, double unit, VoxelType type, const ValueRange& range);

  /// Whether values are labels: then `at` is not asked for values.
  bool ofLabels() const { return of_labels_; }
  /// Of a label less `offset()`: which of those shown it is, from 0; -1 where it is none. cost: a binary search.
  int rankOf(float label) const {
    const auto first = std::lower_bound(labels_.begin(), labels_.end(), label);
    return first != labels_.end() && *first == label ? static_cast<int>(first - labels_.begin()) : -1;
  }
  float opacityOf(int rank) const { return rank < 0 ? 0.0f : label_opacities_[static_cast<std::size_t>(rank)]; }
  /// Where the table has a label of which this much is there, from 0 to 1.
  static float placeOf(int rank, float solid) { return static_cast<float>(2 * rank) + solid; }
  /// What values are shifted by before they become floats, so that large whole numbers keep their last digit.
  double offset() const { return lo_; }
  /// `value` less `offset()`. A value outside of the range is as its end.
  Material at(float value) const {
    const float place = std::min(std::max(value * scale_, 0.0f), last_);
    const auto i = static_cast<std::size_t>(place);
    const float t = place - static_cast<float>(i);
    const Material &a = entries_[i], &b = entries_[i + 1];
    return {a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b), a.tau + t * (b.tau - a.tau)};
  }
  /// What `at` reads. shape: r, g, b, tau an entry; the one after `last` repeats it. unit: entries per value for
  /// `scale`.
  const float* entries() const { return &entries_.front().r; }
  float scale() const { return scale_; }
  float last() const { return last_; }
  /// Of each entry. shape: as entries.
  const float* extinctions() const { return extinctions_.data(); }
  /// `at` gives an extinction above zero only beyond the first of these places and before the second. unit: entries.
  float visibleAfter() const { return visible_after_; }
  float visibleBefore() const { return visible_before_; }
  /// Extinction integrated over the entries, from the first: what it grows by between two places, over their distance,
  /// is the mean extinction of the values between them. It tells places apart that are `leastInterval` from each other.
  /// shape: as entries. unit: extinction times entries.
  const float* integral() const { return integral_.data(); }
  float leastInterval() const { return least_interval_; }
  /// Whether `at` gives an extinction above zero for some value of the range, or nearly so. cost: O(1).
  bool interesting(const ValueRange& range) const;
  /// Whether voxels of this length that hold values of `range` are soft: they look nearly the same all over, so that
  /// fewer samples show as much. `beside_nothing`: what they show may end within them.
  /// requires: not labels. cost: O(1).
  bool soft(const ValueRange& range, double length, bool beside_nothing) const;

 private:
  std::size_t entryBelow(double value) const;
  std::size_t entryAbove(double value) const;
  void addLabels(const std::vector<LabelStyle>& looks, double unit);

  double lo_ = 0;
  float scale_ = 1, last_ = 0;
  float least_interval_ = 1;
  float visible_after_ = 0, visible_before_ = 0;
  std::vector<Material> entries_;
  std::vector<float> extinctions_, integral_;
  std::vector<std::uint32_t> before_;  // entries with extinction, before the i-th
  std::vector<double> changes_;  // of extinction and of light, from the first entry up to each: sums of the larger
  bool of_labels_ = false;
  std::vector<float> labels_, label_opacities_;  // of those shown, by label, less the offset
};

}  // namespace kiln
