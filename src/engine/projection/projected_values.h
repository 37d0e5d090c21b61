// State of pixels while values are projected: the greatest or least value so far, or a sum and its length. For extrema,
// blocks of 8×8 pixels hold a lower bound of their pixels; a brick that exceeds no bound is neither read nor drawn.
#pragma once

#include <algorithm>
#include <vector>

#include "grid/value_range.h"
#include "image/pixel_rect.h"

namespace kiln {

/// The value of a pixel among the values along its ray. kAttenuated: the greatest, each weakened by the values in
/// front.
enum class PixelValue { kGreatest, kLeast, kMean, kAttenuated };

/// The weakening of PixelValue::kAttenuated. Values count by their share of the way from `lo` to `hi`.
struct Attenuation {
  double per_length = 0;  // of the value `hi`. unit: per world length
  double lo = 0, hi = 1;
  double share(double value) const { return hi > lo ? std::clamp((value - lo) / (hi - lo), 0.0, 1.0) : 0; }
};

/// True if the order of samples counts: front to back.
inline bool takesInOrder(PixelValue held) { return held == PixelValue::kMean || held == PixelValue::kAttenuated; }

class ProjectedValues {
 public:
  /// Pixels of `rect` without values.
  ProjectedValues(PixelValue held, const PixelRect& rect, const Attenuation& attenuation = {});
  /// Upper bound of the memory of a pixel. unit: bytes.
  static std::uint64_t bytesOfPixel(PixelValue held) { return takesInOrder(held) ? 17 : 9; }

  const PixelRect& rect() const { return rect_; }
  PixelValue rule() const { return rule_; }
  bool mean() const { return rule_ == PixelValue::kMean; }
  bool attenuated() const { return rule_ == PixelValue::kAttenuated; }
  /// True if the order of samples counts: front to back.
  bool accumulates() const { return takesInOrder(rule_); }
  const Attenuation& attenuation() const { return attenuation_; }
  /// Factor of held values: pixels hold sign() · value, so that every extremum is a maximum.
  double sign() const { return rule_ == PixelValue::kLeast ? -1 : 1; }
  /// Upper bound of held values for values of `range`.
  double bound(const ValueRange& range) const { return rule_ == PixelValue::kLeast ? -range.lo : range.hi; }

  /// Pointer to the extremum or sum of pixel (x, y); pixels to the right follow. requires: (x, y) in rect().
  double* held(int x, int y) { return &held_[placeOf(x, y)]; }
  /// Length over which the sum of pixel (x, y) runs, or the attenuation so far, an exponent; pixels to the right
  /// follow. requires: accumulates().
  double* length(int x, int y) { return &length_[placeOf(x, y)]; }
  /// Marks a pixel whose ray has no value; the pixel never has a value.
  void leaveOut(int x, int y);
  /// Updates the bounds of blocks after extrema in `rect` changed. thread: safe for rectangles that share no block.
  void update(const PixelRect& rect);
  /// True if no further sample can change a pixel of `rect`. requires: attenuated(). thread: as `update`.
  bool closed(const PixelRect& rect) const { return least(rect) >= 0; }
  /// Lower bound of the values held in `rect`; pixels marked by leaveOut do not count. thread: as `update`.
  double least(const PixelRect& rect) const;

  /// Value of a pixel; NaN if the pixel has none.
  double value(int x, int y) const;

 private:
  static constexpr int kBlock = 8;
  std::size_t placeOf(int x, int y) const {
    return static_cast<std::size_t>(y - rect_.y0) * static_cast<std::size_t>(rect_.width()) +
           static_cast<std::size_t>(x - rect_.x0);
  }
  /// Blocks that `rect` touches, counted from the picture's corner, so that tiles share no block.
  PixelRect blocksOf(const PixelRect& rect) const;
  std::size_t blockAt(int x, int y) const {
    return static_cast<std::size_t>(y - blocks_.y0) * static_cast<std::size_t>(blocks_.width()) +
           static_cast<std::size_t>(x - blocks_.x0);
  }

  PixelRect rect_, blocks_;
  PixelValue rule_;
  Attenuation attenuation_;
  std::vector<double> held_, length_, least_;
};

}  // namespace kiln
