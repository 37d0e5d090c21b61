// The cells of 8³ voxels of a brick, for kernels that follow rays through a brick.
#pragma once

#include <algorithm>
#include <glm/vec3.hpp>

#include "store/codec/brick_block.h"

namespace kiln {

/// Places are counted from the brick's first corner, half a voxel before its first voxel. unit: voxels.
class BrickCells {
 public:
  /// requires: `block` outlives this.
  explicit BrickCells(const BrickBlock& block)
      : block_(block), corner_(glm::dvec3(block.core.lo.x, block.core.lo.y, block.core.lo.z) - 0.5) {
    for (int axis = 0; axis < 3; ++axis)
      last_[axis] = static_cast<int>((block.core.hi[axis] - block.core.lo[axis] - 1) / kCellSize);
  }

  /// Returns the place of a point of the level's index space.
  glm::dvec3 placeOf(const glm::dvec3& index) const { return index - corner_; }
  /// Returns the cell along an axis that holds a place. Rounding may put a place just beyond the brick's faces.
  int cellAt(int axis, double place) const {
    return std::clamp(static_cast<int>(place * (1.0 / kCellSize)), 0, last_[axis]);
  }
  /// True if a ray leaves the brick with the cell.
  bool isLast(int axis, int cell, bool forward) const { return cell == (forward ? last_[axis] : 0); }
  /// Returns the place of the face through which a ray leaves the cell.
  static int faceBehind(int cell, bool forward) { return (cell + (forward ? 1 : 0)) * static_cast<int>(kCellSize); }
  /// Range of the values that samples in the cell may have.
  const ValueRange& range(const int (&cell)[3]) const {
    return block_.supports.at(cell[0] + 1, cell[1] + 1, cell[2] + 1);
  }

 private:
  const BrickBlock& block_;
  const glm::dvec3 corner_;
  int last_[3];
};

}  // namespace kiln
