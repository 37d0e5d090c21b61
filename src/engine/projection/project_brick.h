// Projects the values of one brick into one tile: kernel of `--mode mip|minip|average|attenuated-mip`.
// Method. An extremum is exact (engine/shared/brick_extremum.h). Means and attenuated maxima take samples in the middle
// of slabs, which are as thick as the distance of samples; an attenuated maximum also on planes of voxels. A ray whose
// whole interval inside the clip region lies between two samples has a single sample, in the interval's middle.
// Invariant. Positions are counted in the level's index space and slabs in the zone, so that a value has equal bits in
// every brick and tile. A pixel's samples of a brick are taken front to back, so that sums are, too, if bricks are.
#pragma once

#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "engine/projection/pixel_slabs.h"
#include "engine/projection/projected_values.h"
#include "engine/projection/silhouette.h"
#include "engine/shared/draw_counts.h"
#include "scene/clip_region.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// A zone, and the depths of the nearest samples in the zones in front and behind; infinite if there are none.
struct RayZone : SlabZone {
  double before = -std::numeric_limits<double>::infinity(), after = std::numeric_limits<double>::infinity();
};

/// Parameters that all bricks and tiles of a level share.
struct RayFrame {
  const Silhouette* outline = nullptr;   // the frame's; decides the place of each pixel's ray
  std::vector<RayZone> zones;            // zones of the level, near to far; samples are in the middle of slabs
  std::vector<DepthSpan> depths;         // depths of these zones
  const Projector* projector = nullptr;  // belongs to the level
  const ClipRegion* clip = nullptr;      // belongs to the level
  Extent3 dims;                          // belongs to the level
  glm::dvec3 end{0};                     // end of level 0 in the level's index space
};

/// Returns true if the ray through `place` has a value of the level, inside the volume and the clip region. unit:
/// pixels.
bool hasValue(const RayFrame& frame, PixelValue held, const glm::dvec2& place);

/// Takes the brick's values into the pixels of `rect`. An extremum skips cells whose range does not exceed the pixel's
/// value, unless `all`. Counts: visited are samples, or cubes between eight voxels, on the rays; splats are those that
/// are interpolated; nodes are cells on the rays. requires: `rect` inside the values' rectangle; `block` of the frame's
/// level; `bound` is ProjectedValues::bound of the brick's values.
void projectBrick(const RayFrame& frame, const BrickBlock& block, double bound, bool all, const PixelRect& rect,
                  ProjectedValues& values, DrawCounts& counts) noexcept;

/// Takes a brick whose values are all `value`, with the bits that projectBrick would give.
void projectConstant(const RayFrame& frame, const VoxelBox& core, double value, const PixelRect& rect,
                     ProjectedValues& values, DrawCounts& counts) noexcept;

}  // namespace kiln
