// Bars of a histogram in plots, on a logarithmic scale, so that few voxels are seen beside many.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "store/manifest/manifest.h"

namespace kiln {

class HistogramBars {
 public:
  /// requires: the histogram outlives this.
  explicit HistogramBars(const ValueHistogram& histogram) : histogram_(histogram) {
    if (!histogram.counts.empty()) most_ = std::log1p(static_cast<double>(std::ranges::max(histogram.counts)));
  }

  /// Returns the height of the bar at a value, 1 for the most frequent bin; 0 beside the bins.
  double at(double value) const {
    const double width = histogram_.hi - histogram_.lo;
    const double bin = (value - histogram_.lo) / width * static_cast<double>(histogram_.counts.size());
    if (!(width > 0) || !(most_ > 0) || !(bin >= 0 && bin < static_cast<double>(histogram_.counts.size()))) return 0;
    return std::log1p(static_cast<double>(histogram_.counts[static_cast<std::size_t>(bin)])) / most_;
  }

 private:
  const ValueHistogram& histogram_;
  double most_ = 0;
};

}  // namespace kiln
