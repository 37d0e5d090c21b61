// Box and outline of the part of a volume that transfer functions show: a camera fits its picture to the outline.
// Problem. A scan is often mostly air; a picture of its whole box shows the subject small. The box must be known
// before a brick is drawn, in time that a user does not notice.
// Method. (1) The voxels of a coarse level (BrickedVolume::overviewLevel) give the views along the three axes
// (side_views.h): the box around all that counts in them. (2) The sub-ranges of the index bound the values in cubes of
// 1/8 brick. Cubes outside the box that may show something hold matter thinner than a voxel of step 1, which counts by
// its share. (3) The box is cut by the clip region. (4) The outline (shown_outline.h) holds what of the views' cells is
// in the box. Invariant. Box and outline contain what a person sees, but for specks of a negligible share of the
// visible opacity. Both depend on store, functions, region and sections alone. Cost. At most 64 files: one with
// bricks of 128³. The index once: bricks inside the box of step 1 are skipped.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "base/progress.h"
#include "grid/coords.h"
#include "scene/clip_region.h"
#include "scene/transfer/transfer_function.h"
#include "store/bricked_volume.h"

namespace kiln {

struct ShownBox {
  VoxelBox box;                             // of level 0; empty if nothing is shown
  std::vector<glm::dvec3> outline;          // unit: world; the box's corners where step 1 is left out
  std::uint64_t files = 0, file_bytes = 0;  // read for step 1
};

/// Returns the box of what any of the functions shows inside the clip region, whose part is ignored, and of the values
/// on cut faces. With `read_level` false, step 1 is left out, and all cubes that may show something count. requires: at
/// least one function; lengths of the functions are the world's. throws: as BrickedVolume::read; Error kUsage if the
/// region contains no voxel.
ShownBox shownBox(const BrickedVolume& store, std::span<const TransferFunction> functions, const Clipping& clipping,
                  bool read_level = true, const Progress& progress = Progress());

/// Returns the box of the clip region: its planes cut the box if they are parallel to a face of the volume.
VoxelBox boxOfClip(const VolumeGeometry& volume, Clipping clipping);

}  // namespace kiln
