// The slab in turn, for the pixels of one tile: premultiplied light of all of its samples, and what of each pixel they
// fill, opaque or not. Sums are in fixed point, so that they do not depend on the order of samples: pictures are the
// same bit for bit whatever brick or tile a sample came with.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/pixel_rect.h"
#include "splat/aov_sample.h"
#include "splat/refine_unit.h"
#include "splat/tile_windows.h"

namespace kiln {

/// The footprint of a sample: along each axis, what a Gaussian puts into each pixel, which is as wide as itself. Over
/// pixels it sums to one, whatever its place, and over a lattice of samples nearly so. Read at 64 phases, of more than
/// 256 pixels at fewer. Of more than kMostTaps it is cut off.
class FootprintTable {
 public:
  static constexpr int kPhases = FootprintPlace::kPhases;
  static constexpr int kMostTaps = 32000;
  /// Where rows of the second table begin.
  static constexpr int kSoftRows = kPhases;

  /// Of at least `least_taps`: tables of equal taps have equal windows. A second table follows the first, of the
  /// samples of soft voxels, whose Gaussian is no narrower. unit: pixels.
  FootprintTable(double sigma_px, double soft_sigma_px, int least_taps = 0);
  explicit FootprintTable(double sigma_px) : FootprintTable(sigma_px, sigma_px) {}
  /// Pixels along an axis, at least 3: of an odd number the middle one holds the sample, of an even one the border
  /// between the middle ones is the nearest to it.
  int taps() const { return taps_; }
  /// A weight a pixel, and zeros after. shape: padded().
  const float* row(int phase) const { return &rows_[static_cast<std::size_t>((phase >> coarser_) * padded())]; }
  /// The same, each four times. shape: 4 padded().
  const float* wide(int phase) const { return &wide_[static_cast<std::size_t>((phase >> coarser_) * 4 * padded())]; }
  /// taps() rounded up to whole vectors of four pixels, of clipped ones from whichever pixel on.
  int padded() const { return (taps_ + 3) / 4 * 4 + (clipped() ? 4 : 0); }
  bool clipped() const { return taps_ > kMostWholeTaps; }
  /// Beyond this distance from a sample along an axis, no pixel centre takes light from it. unit: pixels.
  double radius() const { return radius_; }

 private:
  void addRows(double sigma_px, double radius);

  int taps_ = 3;
  int coarser_ = 0;  // phases are read 2 to this power at a time
  double radius_ = 1.5;
  std::vector<float> rows_, wide_;
};

class Sheet {
 public:
  /// A sum's unit.
  static constexpr float kOne = 1 << 24;

  /// Empties it for the pixels of `rect`, and for what footprints on its border put beside it, which nobody reads; rows
  /// have room for whole blocks. Clipped footprints put nothing there but the rest of a vector. Sums of colours are of
  /// this unit, a power of two, so that the brightest do not leave what an int holds.
  void reset(const PixelRect& rect, const FootprintTable& footprint, float color_unit = 1);
  float colorUnit() const { return color_unit_; }
  /// unit: bytes.
  std::size_t bytes() const { return (sums_.capacity() + filled_.capacity()) * sizeof sums_[0]; }
  bool empty() const { return dirty_ == 0; }
  /// The pixels that samples were added to: bit 8 y + x of the block of 8×8, counted from the rectangle's corner.
  std::uint64_t dirty() const { return dirty_; }
  PixelRect blockRect(int block) const {
    const int x = rect_.x0 + 8 * (block & 7), y = rect_.y0 + 8 * (block >> 3);
    return intersection({x, y, x + 8, y + 8}, rect_);
  }
  /// shape: RGBA a pixel, from (x, y) on to the right. requires: in the rectangle.
  const std::int32_t* at(int x, int y) const {
    return &sums_[4 * indexOf(x - rect_.x0 + before_, y - rect_.y0 + before_)];
  }
  std::int32_t* at(int x, int y) { return const_cast<std::int32_t*>(std::as_const(*this).at(x, y)); }
  /// What of the pixel samples fill. shape: one a pixel, from (x, y) on to the right; as `at`.
  std::int32_t* filledAt(int x, int y) { return &filled_[indexOf(x - rect_.x0 + before_, y - rect_.y0 + before_)]; }
  /// The same by column and row of the sheet, which begins with the first window; of clipped footprints, with the
  /// rectangle.
  std::int32_t* column(int x, int y) { return &sums_[4 * indexOf(x, y)]; }
  std::int32_t* filledColumn(int x, int y) { return &filled_[indexOf(x, y)]; }
  /// Samples are added to pixels of `blocks`.
  void mark(std::uint64_t blocks) { dirty_ |= blocks; }
  /// All sums are zero again.
  void clear();
  /// The caller has set them to zero.
  void setClear() { dirty_ = 0; }
  std::ptrdiff_t stride() const { return std::ptrdiff_t{4} * width_; }
  const PixelRect& rect() const { return rect_; }

 private:
  std::size_t indexOf(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
  }

  PixelRect rect_;
  float color_unit_ = 1;
  int before_ = 0, width_ = 0;  // columns and rows before the rectangle's, columns in all
  std::uint64_t dirty_ = 0;
  std::vector<std::int32_t> sums_, filled_;
};

/// Adds samples to the sheet of their slab and to the next one. requires: their places are windows of the sheets'
/// rectangle, whose blocks are marked.
void addSamples(std::span<const SlabSample* const> samples, const FootprintTable& footprint, Sheet& here, Sheet& next);

/// The same of sheets whose pixels hold, in the place of RGBA, sums of a normal's three coordinates and of depths from
/// the slab's middle; what samples fill is not in them.
void addAovs(std::span<const AovSample* const> samples, const FootprintTable& footprint, Sheet& here, Sheet& next);

}  // namespace kiln
