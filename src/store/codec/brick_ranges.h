// What the min-max octree and the index say of one brick.
#pragma once

#include <span>
#include <vector>

#include "store/codec/brick_codec.h"
#include "store/ranges/sub_bricks.h"

namespace kiln {

struct BrickRanges {
  /// shape: edge³ cells from the core's first voxel, x fastest; empty ranges outside of the volume.
  std::vector<ValueRange> cells;
  ValueRange core;     // of the brick's own voxels, and of what lies below them
  ValueRange support;  // of every value that is interpolated in core and apron, at this level or below
  /// As subBrickRanges: of this level alone, since a brick draws its own voxels.
  std::vector<ValueRange> sub_bricks;
};

/// The ranges of a brick's own voxels. shape: `voxels` covers frame.stored(), x fastest.
BrickRanges rangesOf(const BrickDesc& frame, std::span<const std::byte> voxels);
/// The same of a decoded brick.
BrickRanges rangesOf(const BrickBlock& block);

}  // namespace kiln
