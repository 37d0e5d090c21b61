// Classification of interpolated values: colour and extinction, linear between the entries of one table over the
// volume's values. Tests of a range agree exactly with the extinctions of its values. For label volumes the table has
// two entries for each visible label: extinction 0 and the label's extinction. For surfaces it has an entry for each
// visible surface.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "engine/pixel/voxels/plane_table.h"
#include "engine/shared/classifier.h"
#include "grid/value_range.h"

namespace kiln {

class SampleTable {
 public:
  /// `range` bounds the values of later calls. Whole-numbered types of up to 16 bits have an entry per value; other
  /// types have a fixed number of entries over classifiedRange.
  SampleTable(const TransferFunction& function, double unit, VoxelType type, const ValueRange& range);

  /// Length that opacities refer to. unit: world.
  double unit() const { return unit_; }
  /// Factors of the opacities by the gradient. Values that no gradient shows have no extinction.
  const PlaneTable& plane() const { return plane_; }
  /// Returns true for label volumes; `at` must then not be called with values.
  bool ofLabels() const { return of_labels_; }
  /// Values (less `offset()`) and opacities of the visible surfaces, in ascending order; entry i of the table is the
  /// i-th surface's. Empty for other functions.
  const std::vector<float>& surfaceValues() const { return surface_values_; }
  const std::vector<float>& surfaceOpacities() const { return surface_opacities_; }
  bool ofSurfaces() const { return of_surfaces_; }
  /// Rank of a label (less `offset()`) among the visible labels, from 0; -1 if invisible. cost: a binary search.
  int rankOf(float label) const {
    const auto first = std::lower_bound(labels_.begin(), labels_.end(), label);
    return first != labels_.end() && *first == label ? static_cast<int>(first - labels_.begin()) : -1;
  }
  float opacityOf(int rank) const { return rank < 0 ? 0.0f : label_opacities_[static_cast<std::size_t>(rank)]; }
  /// Table position of a label of which the share `solid`, from 0 to 1, is present.
  static float placeOf(int rank, float solid) { return static_cast<float>(2 * rank) + solid; }
  /// Subtracted from values before they become floats, so that large whole numbers keep their last digit.
  double offset() const { return lo_; }
  /// Material of a value less `offset()`. Values outside the range are clamped.
  Material at(float value) const {
    const float place = std::min(std::max(value * scale_, 0.0f), last_);
    const auto i = static_cast<std::size_t>(place);
    const float t = place - static_cast<float>(i);
    const Material &a = entries_[i], &b = entries_[i + 1];
    return {a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b), a.tau + t * (b.tau - a.tau)};
  }
  /// Entries that `at` reads. shape: r, g, b, tau per entry; the entry after `last` repeats the last. unit: `scale`:
  /// entries per value.
  const float* entries() const { return &entries_.front().r; }
  float scale() const { return scale_; }
  float last() const { return last_; }
  /// Extinctions of the entries. shape: as entries.
  const float* extinctions() const { return extinctions_.data(); }
  /// `at` returns an extinction above zero only between these table positions, exclusive. unit: entries.
  float visibleAfter() const { return visible_after_; }
  float visibleBefore() const { return visible_before_; }
  /// Integral of extinction over the entries, from the first. The difference between two positions, divided by the
  /// distance, is the mean extinction in between. Positions closer than `leastInterval` cannot be resolved. shape: as
  /// entries.
  /// unit: extinction times entries.
  const float* integral() const { return integral_.data(); }
  float leastInterval() const { return least_interval_; }
  /// Returns true if `at` gives an extinction above zero for some value of the range, or if the range contains values
  /// on both sides of a surface. Slightly conservative. cost: O(1), or the number of surfaces.
  bool interesting(const ValueRange& range) const {
    return one_interval_
               ? !range.empty() && entryPlaceOf(range.hi) > visible_after_ && entryPlaceOf(range.lo) < visible_before_
               : interestingInParts(range);
  }
  /// Returns true if voxels of edge `length` with values in `range` are soft, nearly uniform, so that fewer samples
  /// show as much. requires: not labels. cost: O(1).
  bool soft(const ValueRange& range, double length) const;
  /// Returns true if voxels of edge `length` with values in `range` hold no border of a layer that one sample could
  /// miss or count twice: the change is at most 9/10 of the extinction, or faint. requires: not labels. cost: O(1).
  bool even(const ValueRange& range, double length) const;
  /// Colour (r, g, b) of the values of `range` if all are equal; otherwise null. requires: not labels. cost: O(1).
  const float* oneColor(const ValueRange& range) const;

 private:
  void findSameColors();
  // As a sample's values are converted: less the offset.
  float floatOf(double value) const {
    constexpr double kMost = std::numeric_limits<float>::max();
    return static_cast<float>(std::clamp(value - lo_, -kMost, kMost));
  }
  // Position of a value between the first entry and the last.
  float entryPlaceOf(double value) const {
    return std::min(std::max(static_cast<float>(value - lo_) * scale_, 0.0f), last_);
  }
  bool interestingInParts(const ValueRange& range) const;
  std::size_t entryBelow(double value) const;
  // The larger of the changes of extinction and of light over the values of a range.
  double changeOver(const ValueRange& range) const;
  std::size_t entryAbove(double value) const;
  void addSurfaces(const std::vector<IsoSurface>& surfaces);
  void addLabels(const std::vector<LabelStyle>& looks, double unit);

  double unit_ = 1;
  PlaneTable plane_;
  double lo_ = 0;
  float scale_ = 1, last_ = 0;
  float least_interval_ = 1;
  float visible_after_ = 0, visible_before_ = 0;
  bool one_interval_ = false;  // all entries in between have an extinction above zero: the usual case
  std::vector<Material> entries_;
  std::vector<float> extinctions_, integral_;
  std::vector<std::uint32_t> before_;      // prefix sums: entries with extinction before the i-th
  std::vector<std::uint32_t> same_until_;  // last entry up to which all entries have the i-th's colour
  std::vector<double> changes_;            // prefix sums: the larger of the changes of extinction and of light
  bool of_labels_ = false;
  bool of_surfaces_ = false;
  std::vector<float> surface_values_, surface_opacities_;
  std::vector<float> labels_, label_opacities_;  // visible labels in ascending order, less the offset
};

}  // namespace kiln
