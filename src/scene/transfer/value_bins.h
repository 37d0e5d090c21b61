// The histogram of a volume, and the values at which it is split.
#pragma once

#include <cstddef>
#include <optional>

#include "store/manifest/manifest.h"

namespace kiln {

/// Voxel counts by value; bin b covers [edge(b), edge(b + 1)).
class ValueBins {
 public:
  /// Without bins if the histogram of the manifest is empty or not finite.
  explicit ValueBins(const Manifest& manifest);

  std::size_t size() const { return histogram_.counts.size(); }
  double edge(std::size_t bin) const;
  /// Voxels in the bins from `first` on, before `last`.
  double count(std::size_t first, std::size_t last) const;
  double count(std::size_t bin) const { return static_cast<double>(histogram_.counts[bin]); }

  /// Returns the value that separates empty space from the object: Otsu's threshold. If the upper class is nearly empty
  /// or nearly everything, the other class is split again. Nothing if the volume has fewer than two values.
  std::optional<double> surface() const;
  /// Returns the value that a `fraction` of the voxels outside the lowest bin (empty space) do not exceed.
  double highValue(double fraction, double otherwise) const;
  /// Returns the value that at most a `share` of all voxels exceed.
  double valueExceededBy(double share, double otherwise) const;

 private:
  std::optional<std::size_t> otsuSplit(std::size_t first, std::size_t last) const;

  ValueHistogram histogram_;
};

}  // namespace kiln
