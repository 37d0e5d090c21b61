// The slab in turn, for the pixels of one tile: premultiplied light of all of its samples, and what of each pixel they
// fill, opaque or not. Sums are in
// fixed point, so that they do not depend on the order of samples: pictures are the same bit for bit whatever brick or
// tile a sample came with.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "occlusion/visibility.h"
#include "splat/aov_sample.h"
#include "splat/refine_unit.h"

namespace kiln {

/// The footprint of a sample: along each axis, what a Gaussian puts into each pixel, which is as wide as itself. Over
/// pixels it sums to one, whatever its place, and over a lattice of samples nearly so. Read at 64 phases.
class FootprintTable {
 public:
  static constexpr int kPhases = 64;

  /// unit: pixels.
  explicit FootprintTable(double sigma_px);
  /// Pixels along an axis; an even number, at least 4.
  int taps() const { return taps_; }
  /// The first pixel of a footprint around `at`, and its phase.
  int first(float at, int& phase) const {
    const float base = std::floor(at + 0.5f);
    phase = static_cast<int>((at + 0.5f - base) * kPhases);
    return static_cast<int>(base) - taps_ / 2;
  }
  int first(float at) const { return static_cast<int>(std::floor(at + 0.5f)) - taps_ / 2; }
  /// shape: taps().
  const float* weights(int phase) const { return &weights_[static_cast<std::size_t>(phase * taps_)]; }
  /// The same, each four times, and zeros after. shape: 4 padded().
  /// The same, once, and zeros after. shape: padded().
  const float* row(int phase) const { return &rows_[static_cast<std::size_t>(phase * padded())]; }
  const float* wide(int phase) const { return &wide_[static_cast<std::size_t>(phase * 4 * padded())]; }
  /// taps() rounded up to whole vectors of four pixels.
  int padded() const { return (taps_ + 3) / 4 * 4; }
  /// Beyond this distance from a sample along an axis, no pixel centre takes light from it. unit: pixels.
  double radius() const { return radius_; }

 private:
  int taps_ = 4;
  double radius_ = 2;
  std::vector<float> weights_, wide_, rows_;
};

class Sheet {
 public:
  /// A sum's unit.
  static constexpr float kOne = 1 << 24;

  /// Empties it for the pixels of `rect`; samples may add to `margin` pixels around it, which nobody reads.
  void reset(const PixelRect& rect, int margin);
  /// unit: bytes.
  std::size_t bytes() const {
    return (sums_.capacity() + filled_.capacity()) * sizeof sums_[0] + touched_.capacity() * sizeof touched_[0] +
           dirty_.capacity() * sizeof dirty_[0];
  }
  bool empty() const { return dirty_.empty(); }
  /// The pixels that samples were added to, as blocks of 8×8 that count from the rectangle's corner.
  std::span<const std::int32_t> dirty() const { return dirty_; }
  PixelRect blockRect(std::int32_t block) const {
    const int x = rect_.x0 + 8 * (block % blocks_x_), y = rect_.y0 + 8 * (block / blocks_x_);
    return intersection({x, y, x + 8, y + 8}, rect_);
  }
  int blocks() const { return static_cast<int>(touched_.size()); }
  /// shape: RGBA a pixel, from (x, y) on to the right. requires: in the rectangle, or at most `margin` beside it.
  std::int32_t* at(int x, int y) {
    return &sums_[4 * (static_cast<std::size_t>(y - rect_.y0 + margin_) * static_cast<std::size_t>(width_) +
                       static_cast<std::size_t>(x - rect_.x0 + margin_))];
  }
  /// What of the pixel samples fill. shape: one a pixel, from (x, y) on to the right; as `at`.
  std::int32_t* filledAt(int x, int y) {
    return &filled_[static_cast<std::size_t>(y - rect_.y0 + margin_) * static_cast<std::size_t>(width_) +
                    static_cast<std::size_t>(x - rect_.x0 + margin_)];
  }
  /// Marks the blocks of pixels that `rect` touches.
  void mark(const PixelRect& rect) {
    for (int by = (rect.y0 - rect_.y0) >> 3; by <= (rect.y1 - 1 - rect_.y0) >> 3; ++by) {
      for (int bx = (rect.x0 - rect_.x0) >> 3; bx <= (rect.x1 - 1 - rect_.x0) >> 3; ++bx) {
        const std::int32_t block = by * blocks_x_ + bx;
        if (touched_[static_cast<std::size_t>(block)] != 0) continue;
        touched_[static_cast<std::size_t>(block)] = 1;
        dirty_.push_back(block);
      }
    }
  }
  /// All sums are zero again.
  void clear();
  std::ptrdiff_t stride() const { return std::ptrdiff_t{4} * width_; }

 private:
  PixelRect rect_;
  int margin_ = 0, width_ = 0, blocks_x_ = 0;
  std::vector<std::int32_t> sums_, filled_;
  std::vector<std::uint8_t> touched_;
  std::vector<std::int32_t> dirty_;
};

/// Adds samples to the sheet of their slab and to the next one. requires: each touches the sheets' rectangle, and its
/// blocks are marked.
void addSamples(std::span<const SlabSample> samples, const FootprintTable& footprint, Sheet& here, Sheet& next);

/// The same of sheets whose pixels hold, in the place of RGBA, sums of a normal's three coordinates and of depths from
/// the slab's middle; what samples fill is not in them.
void addAovs(std::span<const AovSample> samples, const FootprintTable& footprint, Sheet& here, Sheet& next);

}  // namespace kiln
