#include "support/volumes/level_volume.h"

#include "store/brick_index.h"
#include "store/codec/brick_block.h"

namespace kiln::test {

DenseVolume levelVolume(const StoreReader& store, int level) {
  DenseVolume out{store.level(level).geometry, VoxelType::f64, {}};
  const Extent3& dims = out.geometry.dims;
  out.voxels.resize(static_cast<std::size_t>(dims.count()) * sizeOf(out.type));
  const Extent3& bricks = store.index().lattice(level);
  for (std::int64_t b = 0; b < bricks.count(); ++b) {
    const BrickBlock block = store.read({level, brickAt(bricks, b)});
    withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
      const VoxelBox& core = block.core;
      for (std::int64_t k = core.lo.z; k < core.hi.z; ++k) {
        for (std::int64_t j = core.lo.y; j < core.hi.y; ++j) {
          for (std::int64_t i = core.lo.x; i < core.hi.x; ++i)
            out.set(i, j, k, static_cast<double>(block.data<T>()[block.offsetOf({i, j, k})]));
        }
      }
    });
  }
  return out;
}

}  // namespace kiln::test
