// Footprint table for orthographic views in which all footprints have equal, axis-aligned ellipses: cubic voxels, or
// any voxels seen along an axis.
// Method. A Gaussian is separable, so a footprint is a row of weights times a column of weights. Both are read from
// tables indexed by phase, the position of the footprint's centre inside a pixel. Weights are computed for the middle
// of a phase.
// Invariant. The weights of every phase sum to one.
// Source: Lee and Ihm (footprint table); Westover 1990.
#pragma once

#include <vector>

#include "engine/shared/projector.h"

namespace kiln {

class VoxelFootprint {
 public:
  /// Phases per pixel. The quantization error of a weight is at most 0.5 % of the largest weight.
  static constexpr int kPhases = 128;
  /// Largest footprint along each axis. unit: pixels.
  static constexpr int kColumns = 8, kRows = 16;
  /// Zeros around a row of weights: a vector of pixels may begin before a footprint and end behind it.
  static constexpr int kBeside = 8;

  /// Returns true if one table serves all voxels of an orthographic view with this ellipse.
  static bool fits(const Ellipse& ellipse);
  /// requires: fits(ellipse).
  explicit VoxelFootprint(const Ellipse& ellipse);

  /// Returns the phase of a footprint. `from_centre` is the offset from the centre to the first pixel's centre, `half`
  /// the half width along the axis. unit: pixels.
  static int phaseOf(float from_centre, float half) {
    const int phase = static_cast<int>((from_centre + half) * static_cast<float>(kPhases));
    return phase < 0 ? 0 : phase < kPhases ? phase : kPhases - 1;
  }
  /// Weights from the footprint's first pixel on, then zeros. Pixels whose centres lie beyond the half width have a
  /// weight of zero. shape: kColumns, with kBeside zeros before and after them; kRows.
  const float* columns(int phase) const {
    return &columns_[static_cast<std::size_t>(kBeside + phase * (kColumns + kBeside))];
  }
  const float* rows(int phase) const { return &rows_[static_cast<std::size_t>(phase * kRows)]; }
  /// Upper bound of the product of a row weight and a column weight.
  float most() const { return most_; }

 private:
  std::vector<float> columns_, rows_;
  float most_;
};

}  // namespace kiln
