// Records the octree nodes tested by a frame and cut by a given plane. Source: Lee and Ihm, figure 7.
#pragma once

#include <cstdint>
#include <vector>

#include "grid/coords.h"

namespace kiln {

struct LoggedNode {
  VoxelBox box;
  int level = 0;  // 0: cell, -1: eighth of a cell
  bool hidden = false;
};

struct NodeLog {
  int axis = 1;            // 0 x, 1 y, 2 z
  std::int64_t plane = 0;  // only nodes with voxels at this coordinate along the axis. unit: voxels
  std::vector<LoggedNode> nodes;

  /// thread: one caller at a time.
  void add(const VoxelBox& box, int level, bool hidden) {
    if (box.lo[axis] <= plane && plane < box.hi[axis]) nodes.push_back({box, level, hidden});
  }
};

}  // namespace kiln
