#include "store/minmax_octree.h"

#include <bit>
#include <cassert>
#include <cmath>

namespace kiln {
namespace {

// Least and greatest of a region, without NaN: `v < lo` is false for it.
template <class T>
ValueRange rangeOfTyped(const T* voxels, const VoxelBox& box, const VoxelBox& region) {
  const Extent3 size = box.extent();
  bool any = false;
  T lo{}, hi{};
  for (std::int64_t z = region.lo.z; z < region.hi.z; ++z) {
    for (std::int64_t y = region.lo.y; y < region.hi.y; ++y) {
      const T* row = voxels + ((z - box.lo.z) * size.y + (y - box.lo.y)) * size.x - box.lo.x;
      for (std::int64_t x = region.lo.x; x < region.hi.x; ++x) {
        const T value = row[x];
        if constexpr (std::is_floating_point_v<T>) {
          if (std::isnan(value)) continue;
        }
        lo = any ? std::min(lo, value) : value;
        hi = any ? std::max(hi, value) : value;
        any = true;
      }
    }
  }
  if (!any) return {};
  return {static_cast<double>(lo), static_cast<double>(hi)};
}

}  // namespace

MinMaxOctree::MinMaxOctree(std::vector<ValueRange> cells, int edge) : edge_(edge) {
  assert(std::has_single_bit(static_cast<unsigned>(edge)));
  assert(cells.size() == static_cast<std::size_t>(edge) * edge * edge);
  levels_.push_back(std::move(cells));
  for (int n = edge / 2; n >= 1; n /= 2) {
    const std::vector<ValueRange>& fine = levels_.back();
    std::vector<ValueRange> coarse(static_cast<std::size_t>(n) * n * n);
    for (int z = 0; z < 2 * n; ++z) {
      for (int y = 0; y < 2 * n; ++y) {
        for (int x = 0; x < 2 * n; ++x) {
          coarse[static_cast<std::size_t>(((z / 2) * n + y / 2) * n + x / 2)].include(
              fine[static_cast<std::size_t>((z * 2 * n + y) * 2 * n + x)]);
        }
      }
    }
    levels_.push_back(std::move(coarse));
  }
}

std::size_t MinMaxOctree::bytes() const {
  std::size_t out = 0;
  for (const auto& level : levels_) out += level.size() * sizeof(ValueRange);
  return out;
}

std::vector<ValueRange> cellRanges(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& box,
                                   const VoxelBox& core, int edge) {
  std::vector<ValueRange> out(static_cast<std::size_t>(edge) * edge * edge);
  std::size_t cell = 0;
  for (int z = 0; z < edge; ++z) {
    for (int y = 0; y < edge; ++y) {
      for (int x = 0; x < edge; ++x, ++cell) {
        const VoxelCoord lo = {core.lo.x + x * kCellSize, core.lo.y + y * kCellSize, core.lo.z + z * kCellSize};
        const VoxelBox region = intersection({lo, {lo.x + kCellSize, lo.y + kCellSize, lo.z + kCellSize}}, core);
        if (!region.empty()) out[cell] = rangeOf(voxels, type, box, region);
      }
    }
  }
  return out;
}

ValueRange rangeOf(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& box, const VoxelBox& region) {
  return withVoxelType(type, [&]<class T>(std::type_identity<T>) {
    return rangeOfTyped(reinterpret_cast<const T*>(voxels.data()), box, region);
  });
}

}  // namespace kiln
