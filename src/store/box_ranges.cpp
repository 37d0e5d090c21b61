#include "store/box_ranges.h"

#include <limits>

#include "base/vectors.h"

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
  KILN_VECTORS void include(std::size_t to, const T* from_lo, const T* from_hi, std::size_t count) noexcept {
    T *const a = lo.data() + to, *const b = hi.data() + to;
    for (std::size_t i = 0; i < count; ++i) {
      a[i] = from_lo[i] < a[i] ? from_lo[i] : a[i];
      b[i] = from_hi[i] > b[i] ? from_hi[i] : b[i];
    }
  }
};

// Along y, then z, then x: whole rows first, so that most of the work is many voxels at a time.
template <class T>
std::vector<ValueRange> boxRangesOf(const T* voxels, const VoxelBox& box,
                                    const std::array<std::vector<VoxelSpan>, 3>& spans) {
  const Extent3 size = box.extent();
  const auto width = static_cast<std::size_t>(size.x);
  const std::size_t ny = spans[1].size(), nz = spans[2].size();
  Rows<T> along_y(width * ny * static_cast<std::size_t>(size.z));
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::size_t j = 0; j < ny; ++j) {
      const std::size_t to = (static_cast<std::size_t>(z) * ny + j) * width;
      for (std::int64_t y = spans[1][j].lo - box.lo.y; y < spans[1][j].hi - box.lo.y; ++y) {
        const T* const from = voxels + (z * size.y + y) * size.x;
        along_y.include(to, from, from, width);
      }
    }
  }
  Rows<T> along_z(width * ny * nz);
  for (std::size_t k = 0; k < nz; ++k) {
    for (std::int64_t z = spans[2][k].lo - box.lo.z; z < spans[2][k].hi - box.lo.z; ++z) {
      const std::size_t from = static_cast<std::size_t>(z) * ny * width;
      along_z.include(k * ny * width, along_y.lo.data() + from, along_y.hi.data() + from, ny * width);
    }
  }
  std::vector<ValueRange> out;
  out.reserve(spans[0].size() * ny * nz);
  for (std::size_t row = 0; row < ny * nz; ++row) {
    for (const VoxelSpan& span : spans[0]) {
      ValueRange range;
      for (std::int64_t x = span.lo - box.lo.x; x < span.hi - box.lo.x; ++x) {
        const std::size_t i = row * width + static_cast<std::size_t>(x);
        if (along_z.lo[i] <= along_z.hi[i])
          range.include({static_cast<double>(along_z.lo[i]), static_cast<double>(along_z.hi[i])});
      }
      out.push_back(range);
    }
  }
  return out;
}

}  // namespace

std::vector<ValueRange> boxRanges(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& box,
                                  const std::array<std::vector<VoxelSpan>, 3>& spans) {
  return withVoxelType(type, [&]<class T>(std::type_identity<T>) {
    return boxRangesOf(reinterpret_cast<const T*>(voxels.data()), box, spans);
  });
}

}  // namespace kiln
