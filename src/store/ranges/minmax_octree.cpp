#include "store/ranges/minmax_octree.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "base/vectors.h"

namespace kiln {
namespace {

// Minimum and maximum of some voxels, ignoring NaN: `v < lo` is false for NaN. Of zeros of both signs the first counts.
template <class T>
class Extremes {
 public:
  void include(const T* values, std::int64_t count) {
    if constexpr (std::is_floating_point_v<T>) {
      for (std::int64_t i = 0; i < count; ++i) {
        if (!std::isnan(values[i])) include(values[i]);
      }
    } else {  // vectorised
      T lo = lo_, hi = hi_;
      for (std::int64_t i = 0; i < count; ++i) {
        lo = std::min(lo, values[i]);
        hi = std::max(hi, values[i]);
      }
      lo_ = lo, hi_ = hi, any_ |= count > 0;
    }
  }
  ValueRange range() const {
    if (!any_) return {};
    return {static_cast<double>(lo_), static_cast<double>(hi_)};
  }

 private:
  void include(T value) {
    lo_ = any_ ? std::min(lo_, value) : value;
    hi_ = any_ ? std::max(hi_, value) : value;
    any_ = true;
  }
  T lo_ = std::numeric_limits<T>::max(), hi_ = std::numeric_limits<T>::lowest();
  bool any_ = false;
};

template <class T>
ValueRange rangeOfTyped(const T* voxels, const VoxelBox& box, const VoxelBox& region) {
  const Extent3 size = box.extent();
  Extremes<T> extremes;
  for (std::int64_t z = region.lo.z; z < region.hi.z; ++z) {
    for (std::int64_t y = region.lo.y; y < region.hi.y; ++y) {
      const T* const row = voxels + ((z - box.lo.z) * size.y + (y - box.lo.y)) * size.x - box.lo.x;
      extremes.include(row + region.lo.x, region.hi.x - region.lo.x);
    }
  }
  return extremes.range();
}

// A row of whole cells of integers: reduces the columns of all cells at once, then the eight columns of each cell.
// requires: `columns` has room for two rows of voxels.
template <class T>
KILN_VECTORS void rangesOfCellRow(const T* first, std::int64_t row, std::int64_t slice, int cells, T* columns,
                                  ValueRange* out) noexcept {
  const std::int64_t width = cells * kCellSize;
  T *const lo = columns, *const hi = lo + width;
  std::copy_n(first, width, lo);
  std::copy_n(first, width, hi);
  for (std::int64_t z = 0; z < kCellSize; ++z) {
    for (std::int64_t y = 0; y < kCellSize; ++y) {
      const T* const from = first + z * slice + y * row;
      for (std::int64_t x = 0; x < width; ++x) {
        lo[x] = std::min(lo[x], from[x]);
        hi[x] = std::max(hi[x], from[x]);
      }
    }
  }
  for (int cell = 0; cell < cells; ++cell) {
    T least = lo[cell * kCellSize], greatest = hi[cell * kCellSize];
    for (std::int64_t x = cell * kCellSize; x < (cell + 1) * kCellSize; ++x) {
      least = std::min(least, lo[x]);
      greatest = std::max(greatest, hi[x]);
    }
    out[cell] = {static_cast<double>(least), static_cast<double>(greatest)};
  }
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
  const Extent3 size = box.extent(), n = core.extent();
  withVoxelType(type, [&]<class T>(std::type_identity<T>) {
    const T* const data = reinterpret_cast<const T*>(voxels.data());
    ValueRange* row = out.data();
    std::vector<T> columns(2 * static_cast<std::size_t>(n.x));
    for (int z = 0; z < edge; ++z) {
      for (int y = 0; y < edge; ++y, row += edge) {
        const VoxelCoord lo = {core.lo.x, core.lo.y + y * kCellSize, core.lo.z + z * kCellSize};
        int x = 0;
        if constexpr (std::is_integral_v<T>) {
          if ((y + 1) * kCellSize <= n.y && (z + 1) * kCellSize <= n.z) {
            x = static_cast<int>(n.x / kCellSize);
            const std::int64_t at = ((lo.z - box.lo.z) * size.y + (lo.y - box.lo.y)) * size.x + (lo.x - box.lo.x);
            rangesOfCellRow(data + at, size.x, size.x * size.y, x, columns.data(), row);
          }
        }
        for (; x < edge; ++x) {
          const VoxelCoord from = {lo.x + x * kCellSize, lo.y, lo.z};
          const VoxelBox cell = {from, {from.x + kCellSize, from.y + kCellSize, from.z + kCellSize}};
          const VoxelBox region = intersection(cell, core);
          if (!region.empty()) row[x] = rangeOfTyped(data, box, region);
        }
      }
    }
  });
  return out;
}

ValueRange rangeOf(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& box, const VoxelBox& region) {
  return withVoxelType(type, [&]<class T>(std::type_identity<T>) {
    return rangeOfTyped(reinterpret_cast<const T*>(voxels.data()), box, region);
  });
}

}  // namespace kiln
