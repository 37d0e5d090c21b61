#include "export/source/store_boxes.h"

#include <optional>

#include "base/thread/parallel.h"
#include "grid/box_copy.h"
#include "store/codec/brick_block.h"
#include "store/codec/brick_codec.h"

namespace kiln {

BricksOfBox::BricksOfBox(const BrickedVolume& store, int level, const VoxelBox& box)
    : store_(store), level_(level), box_(box), bricks_(coarseBox(box, store.manifest().brick_size)) {}

BricksOfBox::Part BricksOfBox::at(std::size_t i) const {
  const BrickCoord inside = brickAt(bricks_.extent(), static_cast<std::int64_t>(i));
  const BrickKey key{level_, brickOf({inside.x + bricks_.lo.x, inside.y + bricks_.lo.y, inside.z + bricks_.lo.z}, 1)};
  return {key, intersection(store_.frame(key).core(), box_)};
}

void readBox(const BrickedVolume& store, int level, const VoxelBox& box, const Progress& progress,
             std::span<std::byte> out) {
  const BricksOfBox bricks(store, level, box);
  const VoxelType type = store.manifest().type;
  parallelForInOrder(bricks.count(), [&](std::size_t i) {
    progress.throwIfCancelled("exporting");
    const auto [key, part] = bricks.at(i);
    if (const std::optional<double> constant = store.constantOf(key)) {
      withVoxelType(type, [&, part = part]<class T>(std::type_identity<T>) {
        const T value = static_cast<T>(*constant);
        fillPart(part, std::as_bytes(std::span(&value, 1)), out, box);
      });
      return;
    }
    const BrickBlock block = store.read(key);
    copyPart(part, block.voxels, block.extent, out, box, sizeOf(type));
  });
}

}  // namespace kiln
