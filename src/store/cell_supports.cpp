#include "store/cell_supports.h"

#include <algorithm>
#include <limits>

#include "store/minmax_octree.h"

namespace kiln {
namespace {

// Least and greatest of whole rows at once. `v < lo` is false for NaN, which is thus left out.
template <class T>
struct Rows {
  std::vector<T> lo, hi;
  explicit Rows(std::size_t count)
      : lo(count,
           std::numeric_limits<T>::has_infinity ? std::numeric_limits<T>::infinity() : std::numeric_limits<T>::max()),
        hi(count, std::numeric_limits<T>::has_infinity ? -std::numeric_limits<T>::infinity()
                                                       : std::numeric_limits<T>::lowest()) {}
  void include(std::size_t to, const T* from_lo, const T* from_hi, std::size_t count) {
    T *const a = lo.data() + to, *const b = hi.data() + to;
    for (std::size_t i = 0; i < count; ++i) {
      a[i] = from_lo[i] < a[i] ? from_lo[i] : a[i];
      b[i] = from_hi[i] > b[i] ? from_hi[i] : b[i];
    }
  }
};

// The voxels of the extent, counted from its first, that support cell c of the axis.
struct Span {
  std::int64_t lo, hi;
};
Span supportOf(int c, std::int64_t core, const VoxelBox& extent, int axis) {
  const std::int64_t first = core + (c - 1) * kCellSize;
  return {std::clamp(first - 1, extent.lo[axis], extent.hi[axis]) - extent.lo[axis],
          std::clamp(first + kCellSize + 1, extent.lo[axis], extent.hi[axis]) - extent.lo[axis]};
}

// Along y, then z, then x: whole rows first, so that most of the work is many voxels at a time.
template <class T>
std::vector<ValueRange> supportsOf(const T* voxels, const VoxelBox& extent, const VoxelCoord& core, int n) {
  const Extent3 size = extent.extent();
  const auto width = static_cast<std::size_t>(size.x), un = static_cast<std::size_t>(n);
  Rows<T> along_y(width * un * static_cast<std::size_t>(size.z));
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (int c = 0; c < n; ++c) {
      const Span span = supportOf(c, core.y, extent, 1);
      const std::size_t to = (static_cast<std::size_t>(z) * un + static_cast<std::size_t>(c)) * width;
      for (std::int64_t y = span.lo; y < span.hi; ++y) {
        const T* const from = voxels + (z * size.y + y) * size.x;
        along_y.include(to, from, from, width);
      }
    }
  }
  Rows<T> along_z(width * un * un);
  for (int c = 0; c < n; ++c) {
    const Span span = supportOf(c, core.z, extent, 2);
    for (std::int64_t z = span.lo; z < span.hi; ++z) {
      const std::size_t from = static_cast<std::size_t>(z) * un * width;
      along_z.include(static_cast<std::size_t>(c) * un * width, along_y.lo.data() + from, along_y.hi.data() + from,
                      un * width);
    }
  }
  std::vector<ValueRange> out(un * un * un);
  for (std::size_t row = 0; row < un * un; ++row) {
    for (int c = 0; c < n; ++c) {
      const Span span = supportOf(c, core.x, extent, 0);
      ValueRange& range = out[row * un + static_cast<std::size_t>(c)];
      for (std::int64_t x = span.lo; x < span.hi; ++x) {
        const std::size_t i = row * width + static_cast<std::size_t>(x);
        if (along_z.lo[i] <= along_z.hi[i])
          range.include({static_cast<double>(along_z.lo[i]), static_cast<double>(along_z.hi[i])});
      }
    }
  }
  return out;
}

}  // namespace

CellSupports::CellSupports(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& extent,
                           const VoxelCoord& core, int edge)
    : edge_(edge + 2) {
  ranges_ = withVoxelType(type, [&]<class T>(std::type_identity<T>) {
    return supportsOf(reinterpret_cast<const T*>(voxels.data()), extent, core, edge_);
  });
}

}  // namespace kiln
