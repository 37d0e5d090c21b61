#include "grid/box_copy.h"

#include <algorithm>
#include <cstring>

namespace kiln {
namespace {

// Calls each(first voxel) for each row of a box.
template <class Each>
void forEachRow(const VoxelBox& box, const Each& each) {
  if (!box.empty()) forEachCoord({box.lo, {box.lo.x + 1, box.hi.y, box.hi.z}}, each);
}

}  // namespace

void copyPart(const VoxelBox& part, std::span<const std::byte> from, const VoxelBox& from_box, std::span<std::byte> to,
              const VoxelBox& to_box, std::size_t voxel_bytes) noexcept {
  const std::size_t row_bytes = static_cast<std::size_t>(part.extent().x) * voxel_bytes;
  forEachRow(part, [&](const VoxelCoord& first) {
    std::memcpy(to.data() + offsetIn(to_box, first) * voxel_bytes,
                from.data() + offsetIn(from_box, first) * voxel_bytes, row_bytes);
  });
}

void copyCommon(std::span<const std::byte> from, const VoxelBox& from_box, std::span<std::byte> to,
                const VoxelBox& to_box, std::size_t voxel_bytes) noexcept {
  copyPart(intersection(from_box, to_box), from, from_box, to, to_box, voxel_bytes);
}

void fillPart(const VoxelBox& part, std::span<const std::byte> voxel, std::span<std::byte> to,
              const VoxelBox& to_box) noexcept {
  if (part.empty()) return;
  std::byte* const row = to.data() + offsetIn(to_box, part.lo) * voxel.size();
  const std::size_t row_bytes = static_cast<std::size_t>(part.extent().x) * voxel.size();
  std::memcpy(row, voxel.data(), voxel.size());
  for (std::size_t done = voxel.size(); done < row_bytes; done *= 2)
    std::memcpy(row + done, row, std::min(done, row_bytes - done));
  forEachRow(part, [&](const VoxelCoord& first) {
    if (first != part.lo) std::memcpy(to.data() + offsetIn(to_box, first) * voxel.size(), row, row_bytes);
  });
}

}  // namespace kiln
