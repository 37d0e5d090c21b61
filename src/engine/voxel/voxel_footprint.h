// The footprint of a voxel where it is the same all over the picture, but for where in a pixel it lies, and its axes
// are the picture's: in orthographic views of cubic voxels, or along an axis of any. It is a row of weights times a
// column of weights, each of them read from a table of phases: what Lee and Ihm call a footprint table. Weights are
// those of the middle of a phase, and sum to one whatever the phase.
#pragma once

#include <vector>

#include "engine/shared/projector.h"

namespace kiln {

class VoxelFootprint {
 public:
  /// Parts of a pixel that are told from one another: a weight is off by up to half a hundredth of the largest.
  static constexpr int kPhases = 128;
  /// The most pixels along each axis.
  static constexpr int kColumns = 8, kRows = 16;
  /// A vector of pixels may begin before a footprint, and end behind it.
  static constexpr int kBeside = 8;

  /// Whether it is the footprint of all voxels of an orthographic view whose ellipse this is.
  static bool fits(const Ellipse& ellipse);
  /// requires: it fits.
  explicit VoxelFootprint(const Ellipse& ellipse);

  /// The phase of a footprint whose first pixel is so far from its centre, along the axis with this half width.
  static int phaseOf(float from_centre, float half) {
    const int phase = static_cast<int>((from_centre + half) * static_cast<float>(kPhases));
    return phase < 0 ? 0 : phase < kPhases ? phase : kPhases - 1;
  }
  /// Weights from the footprint's first pixel on, then zeros; none but zeros beyond the pixels whose centres are within
  /// the half width. shape: kColumns, and kBeside zeros before and behind them; kRows.
  const float* columns(int phase) const {
    return &columns_[static_cast<std::size_t>(kBeside + phase * (kColumns + kBeside))];
  }
  const float* rows(int phase) const { return &rows_[static_cast<std::size_t>(phase * kRows)]; }
  /// No product of a row's weight and a column's is above this.
  float most() const { return most_; }

 private:
  std::vector<float> columns_, rows_;
  float most_;
};

}  // namespace kiln
