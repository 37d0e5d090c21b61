// Box around the part of a volume that transfer functions show: a camera fits its picture to the box.
// Problem. A scan is often mostly air; a picture of its whole box shows the subject small. The box must be known
// before a brick is drawn, in time that a user does not notice.
// Method. (1) The sub-ranges of the index bound the values in cubes of 1/8 brick: the box around all cubes that may
// show something. (2) The box is cut by the clip region. (3) The voxels of the finest level that is one brick move
// each face inward, by at most the size of a cube and the apron.
// Invariant. The box contains every voxel that a function shows with an opacity that changes an 8-bit pixel visibly
// (kLeastAlpha), but for layers too thin for the level of step 3. It depends on store, functions and region alone.
// Cost. The index once: cubes inside the box found so far are skipped. One brick file.
#pragma once

#include <cstdint>
#include <span>

#include "base/progress.h"
#include "grid/coords.h"
#include "scene/clip_region.h"
#include "scene/transfer/transfer_function.h"
#include "store/bricked_volume.h"

namespace kiln {

struct ShownBox {
  VoxelBox box;                             // of level 0; empty if nothing is shown
  std::uint64_t files = 0, file_bytes = 0;  // read for step 3
};

/// Returns the box of what any of the functions shows inside the clip region, whose part is ignored. With `read_brick`
/// false, step 3 is left out. requires: lengths of the functions are the world's. throws: as BrickedVolume::read; Error
/// kUsage if the region contains no voxel.
ShownBox shownBox(const BrickedVolume& store, std::span<const TransferFunction> functions, const Clipping& clipping,
                  bool read_brick = true, const Progress& progress = Progress());

/// Returns the box of the clip region: its planes cut the box if they are parallel to a face of the volume.
VoxelBox boxOfClip(const VolumeGeometry& volume, Clipping clipping);

}  // namespace kiln
