// The definition of sub-bricks in FORMAT.md, as plain loops.
#pragma once

#include "grid/coords.h"

namespace kiln::test {

/// Calls f(i, voxels) for each sub-brick of a brick in the order of the index. `voxels` are the sub-brick's own, 2
/// beyond, and the 6 of the apron at the brick's faces, clipped to the volume; empty if the brick ends before the
/// sub-brick.
template <class F>
void forEachSubBrick(const VoxelBox& core, std::int64_t brick_size, const Extent3& dims, F&& f) {
  const std::int64_t size = brick_size >= 64 ? brick_size / 8 : 8, n = brick_size / size;
  for (std::int64_t i = 0; i < n * n * n; ++i) {
    const std::int64_t at[3] = {i % n, i / n % n, i / n / n};
    VoxelBox box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lo[axis] = core.lo[axis] + at[axis] * size;
      box.hi[axis] = std::min(box.lo[axis] + size, core.hi[axis]);
    }
    const VoxelBox own = box;
    for (int axis = 0; axis < 3 && !own.empty(); ++axis) {
      box.lo[axis] -= own.lo[axis] == core.lo[axis] ? 6 : 2;
      box.hi[axis] += own.hi[axis] == core.hi[axis] ? 6 : 2;
    }
    f(static_cast<std::size_t>(i), own.empty() ? VoxelBox{} : intersection(box, boxOf(dims)));
  }
}

}  // namespace kiln::test
