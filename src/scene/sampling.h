// How a volume is sampled by the pixel lattice.
#pragma once

#include <optional>

#include "scene/interpolation.h"

namespace kiln {

/// How far samples are apart if nothing else is asked for, and what may be. unit: voxels.
inline constexpr double kSampleDistance = 0.5, kLeastSampleDistance = 0.25, kMostSampleDistance = 1;

struct Sampling {
  std::optional<int> level;  // else for each region the one whose voxels are pixel-sized
  Interpolation interpolation = Interpolation::kLinear;
  /// Nearer or farther is faithful or fast. Of a level that fits the view samples are about half a pixel apart at the
  /// least and a pixel at the most, by default three quarters, so that it counts where voxels are larger than half a
  /// pixel. unit: voxels.
  double distance = kSampleDistance;
};

}  // namespace kiln
