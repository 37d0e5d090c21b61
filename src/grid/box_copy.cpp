#include "grid/box_copy.h"

#include <cstring>

namespace kiln {

void copyCommon(std::span<const std::byte> from, const VoxelBox& from_box, std::span<std::byte> to,
                const VoxelBox& to_box, std::size_t voxel_bytes) {
  const VoxelBox common = intersection(from_box, to_box);
  if (common.empty()) return;
  const auto at = [&](const VoxelBox& box, std::int64_t y, std::int64_t z) {
    const Extent3 n = box.extent();
    return static_cast<std::size_t>(((z - box.lo.z) * n.y + (y - box.lo.y)) * n.x + (common.lo.x - box.lo.x)) *
           voxel_bytes;
  };
  for (std::int64_t z = common.lo.z; z < common.hi.z; ++z) {
    for (std::int64_t y = common.lo.y; y < common.hi.y; ++y) {
      std::memcpy(to.data() + at(to_box, y, z), from.data() + at(from_box, y, z),
                  static_cast<std::size_t>(common.extent().x) * voxel_bytes);
    }
  }
}

}  // namespace kiln
