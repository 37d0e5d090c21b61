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
  /// Nearer or farther is faithful or fast. Samples are between half a pixel and a pixel apart in any case, by default
  /// up to three quarters, so that it counts where a voxel is larger than that. unit: voxels.
  double distance = kSampleDistance;
};

}  // namespace kiln
