// Which nodes of the octree a frame asked about where a plane cuts through it: Lee and Ihm's Figure 7.
#pragma once

#include <cstdint>
#include <vector>

#include "grid/coords.h"

namespace kiln {

struct LoggedNode {
  VoxelBox box;
  int level = 0;  // 0 is a cell, -1 an eighth of one
  bool hidden = false;
};

struct NodeLog {
  int axis = 1;            // 0 x, 1 y, 2 z
  std::int64_t plane = 0;  // nodes that hold voxels with this coordinate along the axis. unit: voxels
  std::vector<LoggedNode> nodes;

  /// thread: one caller at a time.
  void add(const VoxelBox& box, int level, bool hidden) {
    if (box.lo[axis] <= plane && plane < box.hi[axis]) nodes.push_back({box, level, hidden});
  }
};

}  // namespace kiln
