// Sampling of a volume between its voxels.
#pragma once

#include <optional>

#include "scene/render_options.h"
#include "store/manifest/manifest.h"

namespace kiln {

struct Sampling {
  std::optional<int> level;  // default: in each region the level whose voxels are about the size of a pixel
  Interpolation interpolation = Interpolation::kLinear;
  /// Distance of samples along a pixel's ray: at least half a pixel, by default at most a pixel or a quarter of a
  /// voxel. Smaller is more faithful, larger is faster. unit: voxels.
  double distance = kSampleDistance;
  /// Only view pixels whose column and row are both even or both odd have rays. View pixels are halves of picture
  /// pixels, so two of four have a ray. Distances along rays refer to picture pixels.
  bool quincunx = false;
  /// For the most rays per pixel (16): uses a finer level if it has few voxels, and samples as near as in larger
  /// pictures. With so many rays, voxels are much smaller than pixels, and coarser levels lose thin layers.
  bool finest = false;
  /// Levels by which regions are drawn coarser than by default, for previews. Ignored if `level` is given.
  int coarser = 0;
};

/// Returns the level to draw if a world length of 1 is `scale` pixels: the coarsest level whose voxels are at most
/// kMostCoarseVoxel, or the finest level. With `finest` (Sampling::finest), returns the next finer level if that has at
/// most kMostOversampledVoxels.
int levelAtScale(const Manifest& volume, double scale, bool finest = false);
/// Upper bound for a level drawn for more samples per pixel: a quarter of a GiB at 16 bits. A finer level has eight
/// times the bytes to read.
inline constexpr std::int64_t kMostOversampledVoxels = std::int64_t{1} << 27;
/// Depth zones (engine/shared/slab_grid.h) are an eighth of an octave. So a perspective view with half a pixel per
/// voxel in its middle uses a single level, and its far half no coarser level. With a smaller value, footprints of the
/// halved voxels would exceed a brick's apron. unit: pixels.
inline constexpr double kMostCoarseVoxel = 7.0 / 8;

}  // namespace kiln
