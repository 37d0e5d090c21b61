// All value ranges of a brick, for its octree and the index.
#pragma once

#include <span>
#include <vector>

#include "store/codec/brick_codec.h"
#include "store/ranges/sub_bricks.h"

namespace kiln {

struct BrickRanges {
  /// shape: edge³ cells from the core's first voxel on, x fastest; empty ranges outside the volume.
  std::vector<ValueRange> cells;
  ValueRange core;     // voxels of the brick and all finer voxels below
  ValueRange support;  // every value interpolated in core and apron, at this level or below
  /// As subBrickRanges: of this level only, because a brick draws its own voxels.
  std::vector<ValueRange> sub_bricks;
};

/// Computes the ranges of a brick's own voxels. shape: `voxels` covers frame.stored(), x fastest.
BrickRanges rangesOf(const BrickDesc& frame, std::span<const std::byte> voxels);
/// Computes the ranges of a decoded brick's own voxels.
BrickRanges rangesOf(const BrickBlock& block);

}  // namespace kiln
