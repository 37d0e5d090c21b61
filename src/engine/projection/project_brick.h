// The kernel of `--mode mip|minip|average`: one brick in one tile. A zone's slabs are as thick as samples are apart: a
// pixel takes, of each slab whose middle its ray meets in the brick, the value there, interpolated linearly. A ray
// whose whole stretch inside the clipping lies between two samples has one at the stretch's middle. Places are counted
// in the level's index space and slabs in the zone, so that a sample is the same bit for bit whatever brick or tile it
// is taken in; and a pixel's samples are taken from front to back in each brick, so that with bricks in that order sums
// are, too.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "engine/projection/pixel_slabs.h"
#include "engine/projection/projected_values.h"
#include "engine/shared/draw_counts.h"
#include "scene/clip_region.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// What all bricks and tiles of a level share.
struct RayFrame {
  std::vector<SlabZone> zones;           // of the level, near to far; samples at the middles of their slabs
  const Projector* projector = nullptr;  // of the level
  const ClipRegion* clip = nullptr;      // the same
  Extent3 dims;                          // the same
  glm::dvec3 end{0};                     // where level 0 ends in the level's index space
};

/// Whether the ray of pixel (x, y) has a sample of the level in the volume and inside of the clipping.
bool hasSample(const RayFrame& frame, int x, int y);

/// Takes the brick's samples into the pixels of `rect`. An extremum is looked for where the range of a cell goes beyond
/// what the pixel holds, unless `all`. Of the counts, visited are samples on the rays, splats those interpolated, nodes
/// the cells that rays pass. requires: `rect` of the values; `block` of the frame's level; `bound` of its values.
void projectBrick(const RayFrame& frame, const BrickBlock& block, double bound, bool all, const PixelRect& rect,
                  ProjectedValues& values, DrawCounts& counts) noexcept;

/// The same of a brick all of whose samples are `value`.
void projectConstant(const RayFrame& frame, const VoxelBox& core, double value, const PixelRect& rect,
                     ProjectedValues& values, DrawCounts& counts) noexcept;

}  // namespace kiln
