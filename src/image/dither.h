// Ordered dithering of 8-bit pictures: a fixed pattern of thresholds turns the fraction lost by rounding into
// neighbours of different bytes, so that smooth gradients have no bands. Invariant. A threshold depends on the position
// in the whole picture alone, so that a crop has the picture's bytes. A colour within 1/128 of a byte is that byte
// everywhere. Source: Bayer 1973, an optimum method for two-level rendition of continuous-tone pictures.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace kiln {

inline constexpr int kDitherEdge = 8;  // the pattern's period. unit: pixels

/// The thresholds of one row of pixels, in (0, 1): a fraction f of a byte rounds up where f + threshold >= 1.
class DitherRow {
 public:
  /// requires: y >= 0.
  explicit DitherRow(int y) {
    constexpr int kLevels = kDitherEdge * kDitherEdge;
    for (int x = 0; x < kDitherEdge; ++x) {
      // The bits of x ^ y and y, interleaved from the lowest up.
      int rank = 0;
      for (int bit = 1; bit < kDitherEdge; bit *= 2) rank = 4 * rank + 2 * (((x ^ y) & bit) != 0) + ((y & bit) != 0);
      thresholds_[static_cast<std::size_t>(x)] = (rank + 0.5) / kLevels;
    }
  }
  /// requires: x >= 0.
  double at(int x) const { return thresholds_[static_cast<std::size_t>(x % kDitherEdge)]; }

 private:
  std::array<double, kDitherEdge> thresholds_;
};

}  // namespace kiln
