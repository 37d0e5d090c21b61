// How a volume is sampled where it is sampled between its voxels.
#pragma once

#include <optional>

#include "scene/interpolation.h"
#include "store/manifest.h"

namespace kiln {

/// How far samples are apart if nothing else is asked for, and what may be. unit: voxels.
inline constexpr double kSampleDistance = 0.5, kLeastSampleDistance = 0.25, kMostSampleDistance = 1;

struct Sampling {
  std::optional<int> level;  // else for each region the one whose voxels are pixel-sized
  Interpolation interpolation = Interpolation::kLinear;
  /// How far samples are apart along a pixel's ray: half a pixel at the least, by default a pixel at the most. Nearer
  /// or farther is faithful or fast. unit: voxels.
  double distance = kSampleDistance;
  /// Of the view's pixels, only those whose column and row are both even or both odd have rays: they are halves of the
  /// picture's pixels, two of four. Distances along rays are those of the picture's.
  bool quincunx = false;
};

/// The level that is drawn where a world length of 1 is `scale` pixels: the coarsest whose voxels are no larger than
/// kMostCoarseVoxel, or the finest.
int levelAtScale(const Manifest& volume, double scale);
/// Zones of depth (splat/slab_grid.h) are an eighth of an octave: in perspective, a view whose middle has half a pixel
/// a voxel is of one level then, and not its far half of a coarser one. Were it less again, footprints of the voxels
/// that it halves would reach farther than a brick's apron. unit: pixels.
inline constexpr double kMostCoarseVoxel = 7.0 / 8;

}  // namespace kiln
