// Visits the voxels of a decoded brick.
#pragma once

#include "store/codec/brick_block.h"

namespace kiln {

/// Calls each(coordinate, value) for the voxels of `part` of a block, x fastest. requires: `part` lies in the block's
/// extent; the block holds values of type T.
template <class T, class Each>
void forEachVoxel(const BrickBlock& block, const VoxelBox& part, const Each& each) {
  const T* const voxels = block.data<T>();
  for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
    for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) {
      const T* const row = voxels + block.offsetOf({part.lo.x, y, z});
      for (std::int64_t x = part.lo.x; x < part.hi.x; ++x) each(VoxelCoord{x, y, z}, row[x - part.lo.x]);
    }
  }
}

}  // namespace kiln
