// Bars of a histogram in plots, on a logarithmic scale, so that few voxels are seen beside many.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "store/manifest/manifest.h"

namespace kiln {

class HistogramBars {
 public:
  /// requires: the histogram outlives this.
  explicit HistogramBars(const ValueHistogram& histogram) : histogram_(histogram) {
    if (!histogram.counts.empty()) most_ = std::log1p(static_cast<double>(std::ranges::max(histogram.counts)));
  }

  /// Returns the height of the highest bar between two values, 1 for the most frequent bin; 0 beside the bins.
  double over(double lo, double hi) const {
    const double width = histogram_.hi - histogram_.lo, bins = static_cast<double>(histogram_.counts.size());
    if (!(most_ > 0) || hi <= histogram_.lo || lo > histogram_.hi) return 0;
    // All voxels of a volume of one value are in its bins.
    if (!(width > 0)) return 1;
    const auto binOf = [&](double value) { return std::clamp((value - histogram_.lo) / width * bins, 0.0, bins); };
    const auto first = static_cast<std::size_t>(binOf(lo)), end = static_cast<std::size_t>(std::ceil(binOf(hi)));
    std::uint64_t count = 0;
    for (std::size_t i = first; i < end; ++i) count = std::max(count, histogram_.counts[i]);
    return std::log1p(static_cast<double>(count)) / most_;
  }

 private:
  const ValueHistogram& histogram_;
  double most_ = 0;
};

}  // namespace kiln
