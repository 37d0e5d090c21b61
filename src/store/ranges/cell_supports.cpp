#include "store/ranges/cell_supports.h"

#include <algorithm>

#include "store/ranges/box_ranges.h"
#include "store/ranges/minmax_octree.h"

namespace kiln {
namespace {

// The voxels of the extent that support each cell along an axis.
std::vector<VoxelSpan> supportsAlong(int axis, std::int64_t core, const VoxelBox& extent, int edge) {
  std::vector<VoxelSpan> out;
  for (int c = 0; c < edge; ++c) {
    const std::int64_t first = core + (c - 1) * kCellSize;
    out.push_back({std::clamp(first - 1, extent.lo[axis], extent.hi[axis]),
                   std::clamp(first + kCellSize + 1, extent.lo[axis], extent.hi[axis])});
  }
  return out;
}

}  // namespace

CellSupports::CellSupports(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& extent,
                           const VoxelCoord& core, int edge)
    : edge_(edge + 2) {
  ranges_ = boxRanges(voxels, type, extent,
                      {supportsAlong(0, core.x, extent, edge_), supportsAlong(1, core.y, extent, edge_),
                       supportsAlong(2, core.z, extent, edge_)});
}

}  // namespace kiln
