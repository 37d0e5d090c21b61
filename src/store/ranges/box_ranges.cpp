#include "store/ranges/box_ranges.h"

#include <algorithm>
#include <limits>

#include "base/vectors.h"

namespace kiln {
namespace {

// The start values of a minimum (kGreatest) and a maximum (kLeast).
template <class T>
struct Ends {
  using Limits = std::numeric_limits<T>;
  static constexpr T kGreatest = Limits::has_infinity ? Limits::infinity() : Limits::max();
  static constexpr T kLeast = Limits::has_infinity ? -Limits::infinity() : Limits::lowest();
};

// Minimum and maximum of each column over some rows. `v < lo` is false for NaN, so NaN is ignored.
template <class T>
struct ColumnBounds {
  std::vector<T> lo, hi;
  explicit ColumnBounds(std::size_t count) : lo(count), hi(count) {}

  // Sets the bounds over `rows` rows, `stride` apart. Columns are processed in groups whose bounds stay in registers.
  KILN_VECTORS void set(std::size_t to, const T* from_lo, const T* from_hi, std::size_t stride, std::size_t rows,
                        std::size_t columns) noexcept {
    constexpr std::size_t kAtATime = 32;
    if (columns < kAtATime) {
      for (std::size_t x = 0; x < columns; ++x) setSome<1>(to, from_lo, from_hi, stride, rows, x);
      return;
    }
    // The last group overlaps the group before, if columns are left over.
    for (std::size_t x = 0; x < columns; x += kAtATime)
      setSome<kAtATime>(to, from_lo, from_hi, stride, rows, std::min(x, columns - kAtATime));
  }

  // Range of `count` columns together.
  ValueRange range(std::size_t first, std::size_t count) const {
    T least = Ends<T>::kGreatest, most = Ends<T>::kLeast;
    for (std::size_t i = first; i < first + count; ++i) {
      least = std::min(least, lo[i]);
      most = std::max(most, hi[i]);
    }
    return least <= most ? ValueRange{static_cast<double>(least), static_cast<double>(most)} : ValueRange{};
  }

 private:
  template <std::size_t kCount>
  void setSome(std::size_t to, const T* from_lo, const T* from_hi, std::size_t stride, std::size_t rows,
               std::size_t first) noexcept {
    T least[kCount], most[kCount];
    for (std::size_t i = 0; i < kCount; ++i) least[i] = Ends<T>::kGreatest, most[i] = Ends<T>::kLeast;
    for (std::size_t y = 0; y < rows; ++y) {
      const T *const a = from_lo + y * stride + first, *const b = from_hi + y * stride + first;
      for (std::size_t i = 0; i < kCount; ++i) {
        least[i] = a[i] < least[i] ? a[i] : least[i];
        most[i] = b[i] > most[i] ? b[i] : most[i];
      }
    }
    for (std::size_t i = 0; i < kCount; ++i) lo[to + first + i] = least[i], hi[to + first + i] = most[i];
  }
};

// Reduces along y, then z, then x: whole rows first, so most work is vectorised.
template <class T>
std::vector<ValueRange> boxRangesOf(const T* voxels, const VoxelBox& box,
                                    const std::array<std::vector<VoxelSpan>, 3>& spans) {
  const Extent3 size = box.extent();
  const auto width = static_cast<std::size_t>(size.x), height = static_cast<std::size_t>(size.y);
  const auto first = [&](const VoxelSpan& span, int axis) { return static_cast<std::size_t>(span.lo - box.lo[axis]); };
  const auto count = [](const VoxelSpan& span) { return static_cast<std::size_t>(span.hi - span.lo); };
  const std::size_t ny = spans[1].size(), plane = ny * width;
  std::size_t longest = 0;
  for (const VoxelSpan& span : spans[2]) longest = std::max(longest, count(span));
  ColumnBounds<T> along_y(plane * longest), along_z(plane);
  std::vector<ValueRange> out;
  out.reserve(spans[0].size() * ny * spans[2].size());
  // Planes shared by two spans along z are reduced twice: the reduced rows of all planes would exceed the processor's
  // cache.
  for (const VoxelSpan& planes : spans[2]) {
    for (std::size_t z = 0; z < count(planes); ++z) {
      for (std::size_t j = 0; j < ny; ++j) {
        const T* const from = voxels + ((first(planes, 2) + z) * height + first(spans[1][j], 1)) * width;
        along_y.set(z * plane + j * width, from, from, width, count(spans[1][j]), width);
      }
    }
    along_z.set(0, along_y.lo.data(), along_y.hi.data(), plane, count(planes), plane);
    for (std::size_t j = 0; j < ny; ++j) {
      for (const VoxelSpan& span : spans[0]) out.push_back(along_z.range(j * width + first(span, 0), count(span)));
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
