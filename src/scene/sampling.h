// How a volume is sampled where it is sampled between its voxels.
#pragma once

#include <optional>

#include "scene/interpolation.h"
#include "store/manifest/manifest.h"

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
  /// Of the most rays a pixel (16): a level finer where that has few voxels, and samples as near as those of larger
  /// pictures. Whoever takes so many has voxels much smaller than pixels, of which coarser levels lose thin layers.
  bool finest = false;
};

/// The level that is drawn where a world length of 1 is `scale` pixels: the coarsest whose voxels are no larger than
/// kMostCoarseVoxel, or the finest. `finest` as Sampling has it: the level before, where that has at most
/// kMostOversampledVoxels.
int levelAtScale(const Manifest& volume, double scale, bool finest = false);
/// Of a level that is shown for the sake of more samples a pixel: a quarter of a GiB at 16 bits. A level finer has
/// eight times the bytes to read.
inline constexpr std::int64_t kMostOversampledVoxels = std::int64_t{1} << 27;
/// Zones of depth (engine/shared/slab_grid.h) are an eighth of an octave: in perspective, a view whose middle has half
/// a pixel a voxel is of one level then, and not its far half of a coarser one. Were it less again, footprints of the
/// voxels that it halves would reach farther than a brick's apron. unit: pixels.
inline constexpr double kMostCoarseVoxel = 7.0 / 8;

}  // namespace kiln
