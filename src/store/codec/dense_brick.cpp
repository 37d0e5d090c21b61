#include "store/codec/dense_brick.h"

#include <algorithm>
#include <utility>

#include "grid/box_copy.h"
#include "store/manifest/manifest.h"

namespace kiln {
namespace {

// Axis by axis: rows, then the rows of a slice, then slices.
template <class T>
void clampEdgesOf(T* voxels, const VoxelBox& all, const VoxelBox& stored) {
  const Extent3 n = all.extent();
  const auto nearest = [&](std::int64_t i, int axis) {
    return std::clamp(i, stored.lo[axis], stored.hi[axis] - 1) - all.lo[axis];
  };
  for (std::int64_t z = stored.lo.z; z < stored.hi.z; ++z) {
    for (std::int64_t y = stored.lo.y; y < stored.hi.y; ++y) {
      T* const row = voxels + ((z - all.lo.z) * n.y + (y - all.lo.y)) * n.x;
      const std::int64_t first = stored.lo.x - all.lo.x, end = stored.hi.x - all.lo.x;
      std::fill(row, row + first, row[first]);
      std::fill(row + end, row + n.x, row[end - 1]);
    }
    T* const slice = voxels + (z - all.lo.z) * n.y * n.x;
    for (std::int64_t y = 0; y < n.y; ++y) {
      const std::int64_t from = nearest(y + all.lo.y, 1);
      if (from != y) std::copy_n(slice + from * n.x, n.x, slice + y * n.x);
    }
  }
  for (std::int64_t z = 0; z < n.z; ++z) {
    const std::int64_t from = nearest(z + all.lo.z, 2);
    if (from != z) std::copy_n(voxels + from * n.y * n.x, n.y * n.x, voxels + z * n.y * n.x);
  }
}

}  // namespace

BrickDesc descOf(const Manifest& manifest, const BrickKey& key) {
  return {key, manifest.type, manifest.brick_size, manifest.apron,
          manifest.levels[static_cast<std::size_t>(key.level)].geometry};
}

BrickBlock emptyBlock(const BrickDesc& brick) {
  BrickBlock block;
  block.key = brick.key;
  block.type = brick.type;
  block.core = brick.core();
  block.extent = dilated(block.core, brick.apron);
  block.voxels.resize(static_cast<std::size_t>(block.extent.count()) * sizeOf(brick.type));
  return block;
}

void clampEdges(BrickBlock& block, const VoxelBox& stored) {
  withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
    clampEdgesOf(reinterpret_cast<T*>(block.voxels.data()), block.extent, stored);
  });
}

CellSupports supportsOf(const BrickBlock& block) {
  return CellSupports(block.voxels, block.type, block.extent, block.core.lo, block.octree.edge(0));
}

BrickBlock denseBrick(const BrickDesc& brick, std::span<const std::byte> voxels, const VoxelBox& box,
                      std::vector<ValueRange> cells) {
  BrickBlock block = emptyBlock(brick);
  copyCommon(voxels, box, block.voxels, block.extent, sizeOf(brick.type));
  clampEdges(block, brick.stored());
  block.octree = MinMaxOctree(std::move(cells), static_cast<int>(brick.brick_size / kCellSize));
  block.supports = supportsOf(block);
  return block;
}

std::size_t denseBytes(const BrickDesc& brick) {
  const std::int64_t edge = brick.brick_size / kCellSize;
  return blockBytes(brick) + static_cast<std::size_t>(brick.stored().count()) * sizeOf(brick.type) +
         static_cast<std::size_t>(edge * edge * edge) * sizeof(ValueRange) +
         CellSupports::scratchBytes(brick.brick_size, brick.apron, brick.type);
}

}  // namespace kiln
