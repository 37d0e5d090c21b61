// Values of a companion in a cell (BrickBlock::color_values), as positions in the table of its colours.
#pragma once

#include "engine/pixel/voxels/load_patch.h"
#include "engine/pixel/voxels/sample_table.h"
#include "store/codec/brick_block.h"

namespace kiln {

struct ColorPatch {
  /// NaN: the volume's own colour. shape: as loadPatch's.
  alignas(64) float places[kPatchEdge * kPatchEdge * kPatchStride];
};

/// Loads the cell whose first voxel is `lo`. Labels without a colour are NaN. requires: the block has such values.
/// thread: safe.
void loadColors(const BrickBlock& block, const SampleTable& table, const VoxelCoord& lo, ColorPatch& out);

}  // namespace kiln
