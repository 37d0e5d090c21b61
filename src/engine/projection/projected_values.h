// What pixels hold while values are projected: the greatest so far, or the least, or a sum and the length that it is
// over. A brick that has nothing beyond what its pixels hold is not drawn, and not read: of the extremum, blocks of 8×8
// pixels know what all of theirs hold at least.
#pragma once

#include <vector>

#include "grid/value_range.h"
#include "image/pixel_rect.h"
#include "scene/render_options.h"

namespace kiln {

class ProjectedValues {
 public:
  /// No pixel of `rect` has a value yet. requires: a mode that projects one.
  ProjectedValues(Mode mode, const PixelRect& rect);
  /// What it takes a pixel, and a little more. unit: bytes.
  static std::uint64_t bytesOfPixel(Mode mode) { return mode == Mode::kAverage ? 17 : 9; }

  const PixelRect& rect() const { return rect_; }
  bool mean() const { return mean_; }
  /// Held is `sign` times the value, so that an extremum is always the greatest of what is held.
  double sign() const { return sign_; }
  /// The greatest that may be held of values of the range.
  double bound(const ValueRange& range) const { return sign_ > 0 ? range.hi : -range.lo; }

  /// The extremum or the sum, of pixel (x, y) and then to the right. requires: in the rectangle.
  double* held(int x, int y) { return &held_[placeOf(x, y)]; }
  /// The length that the sum is over. requires: mean().
  double* length(int x, int y) { return &length_[placeOf(x, y)]; }
  /// The pixel will never have a value, and shows no part of the volume.
  void leaveOut(int x, int y);
  /// Pixels of `rect` hold other extrema than before. thread: for rectangles that touch no common block.
  void update(const PixelRect& rect);
  /// What every pixel of `rect` holds at least; those left out do not count. thread: as `update`.
  double least(const PixelRect& rect) const;

  /// NaN where there is none.
  double value(int x, int y) const;

 private:
  static constexpr int kBlock = 8;
  std::size_t placeOf(int x, int y) const {
    return static_cast<std::size_t>(y - rect_.y0) * static_cast<std::size_t>(rect_.width()) +
           static_cast<std::size_t>(x - rect_.x0);
  }
  /// The blocks that `rect` touches, counted from the picture's corner, so that tiles share none.
  PixelRect blocksOf(const PixelRect& rect) const;
  std::size_t blockAt(int x, int y) const {
    return static_cast<std::size_t>(y - blocks_.y0) * static_cast<std::size_t>(blocks_.width()) +
           static_cast<std::size_t>(x - blocks_.x0);
  }

  PixelRect rect_, blocks_;
  bool mean_;
  double sign_;
  std::vector<double> held_, length_, least_;
};

}  // namespace kiln
