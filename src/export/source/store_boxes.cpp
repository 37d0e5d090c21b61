#include "export/source/store_boxes.h"

#include <cstring>

#include "base/thread/parallel.h"
#include "store/codec/brick_block.h"

namespace kiln {
namespace {

// The bricks that meet a box. shape: a box of the brick lattice.
VoxelBox bricksOf(const VoxelBox& box, std::int64_t brick_size) {
  VoxelBox out;
  for (int axis = 0; axis < 3; ++axis) {
    out.lo[axis] = box.lo[axis] / brick_size;
    out.hi[axis] = (box.hi[axis] + brick_size - 1) / brick_size;
  }
  return out;
}

}  // namespace

void copyVoxels(const VoxelBox& part, std::size_t voxel_bytes, const VoxelBox& from_box, const std::byte* from,
                const VoxelBox& to_box, std::byte* to) noexcept {
  const auto placeIn = [&](const VoxelBox& box, std::int64_t y, std::int64_t z) {
    const Extent3 extent = box.extent();
    const std::int64_t row = (z - box.lo.z) * extent.y + y - box.lo.y;
    return static_cast<std::size_t>(row * extent.x + part.lo.x - box.lo.x) * voxel_bytes;
  };
  const std::size_t row_bytes = static_cast<std::size_t>(part.extent().x) * voxel_bytes;
  for (std::int64_t z = part.lo.z; z < part.hi.z; ++z)
    for (std::int64_t y = part.lo.y; y < part.hi.y; ++y)
      std::memcpy(to + placeIn(to_box, y, z), from + placeIn(from_box, y, z), row_bytes);
}

void readBox(const StoreReader& store, int level, const VoxelBox& box, const Progress& progress,
             std::span<std::byte> out) {
  const VoxelBox bricks = bricksOf(box, store.manifest().brick_size);
  const std::size_t voxel_bytes = sizeOf(store.manifest().type);
  parallelForInOrder(static_cast<std::size_t>(bricks.count()), [&](std::size_t i) {
    progress.throwIfCancelled("exporting");
    const BrickCoord inside = brickAt(bricks.extent(), static_cast<std::int64_t>(i));
    const BrickKey key{
        level,
        {static_cast<std::int32_t>(inside.x + bricks.lo.x), static_cast<std::int32_t>(inside.y + bricks.lo.y),
         static_cast<std::int32_t>(inside.z + bricks.lo.z)}};
    const BrickBlock block = store.read(key);
    copyVoxels(intersection(block.core, box), voxel_bytes, block.extent, block.voxels.data(), box, out.data());
  });
}

}  // namespace kiln
