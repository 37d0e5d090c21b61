#include "convert/pyramid/half_brick.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/byte_record.h"
#include "base/error.h"
#include "base/vectors.h"
#include "grid/box_copy.h"

namespace kiln {
namespace {

// Type for the sum of a mean: exact for integers, with spare bits for floats.
template <class T>
struct SumOf {
  using type = std::conditional_t<sizeof(T) <= 2, std::int32_t, std::int64_t>;
};
template <>
struct SumOf<float> {
  using type = double;
};
template <>
struct SumOf<double> {
  using type = long double;
};

template <class T, class Sum>
T meanOf(Sum sum, int count) {
  if constexpr (std::is_floating_point_v<T>) {
    return count == 0 ? std::numeric_limits<T>::quiet_NaN() : static_cast<T>(sum / static_cast<Sum>(count));
  } else {
    // floor(mean + 1/2), also below zero. `count` is a power of two, because each axis contributes one or two voxels.
    return static_cast<T>((2 * sum + count) >> (std::countr_zero(static_cast<unsigned>(count)) + 1));
  }
}

// The fine voxels of the volume below one coarse voxel, along one axis.
struct Below {
  std::int64_t lo, hi;
};
Below below(std::int64_t coarse, std::int64_t by, std::int64_t end) {
  return {coarse * by, std::min((coarse + 1) * by, end)};
}

template <class T>
class Halver {
 public:
  using Sum = typename SumOf<T>::type;

  Halver(const T* voxels, const VoxelBox& box, const VoxelBox& core, const Extent3& by)
      : voxels_(voxels), box_(box), core_(core), size_(box.extent()), by_(by) {
    sums_.resize(static_cast<std::size_t>(core.extent().x));
    counts_.resize(sums_.size());
  }

  KILN_VECTORS void run(const VoxelBox& coarse, T* out) noexcept {
    for (std::int64_t z = coarse.lo.z; z < coarse.hi.z; ++z) {
      for (std::int64_t y = coarse.lo.y; y < coarse.hi.y; ++y) {
        const int rows = sumRows(below(y, by_.y, core_.hi.y), below(z, by_.z, core_.hi.z));
        out = by_.x == 2 ? meansAlong<2>(rows, out) : meansAlong<1>(rows, out);
      }
    }
  }

 private:
  // Makes a coarse row from the sums of the rows below it; returns the begin of the next row.
  template <std::size_t kBy>
  T* meansAlong(int rows, T* out) const {
    const Sum* const sums = sums_.data();
    const auto countAt = [&](std::size_t i) { return std::is_floating_point_v<T> ? counts_[i] : rows; };
    const std::size_t whole = sums_.size() / kBy;
    for (std::size_t x = 0; x < whole; ++x) {
      Sum sum = sums[kBy * x];
      int count = countAt(kBy * x);
      if constexpr (kBy == 2) {
        sum += sums[kBy * x + 1];
        count += countAt(kBy * x + 1);
      }
      out[x] = meanOf<T>(sum, count);
    }
    // The volume ends in the middle of a coarse voxel.
    if (kBy * whole < sums_.size()) out[whole] = meanOf<T>(sums[kBy * whole], countAt(kBy * whole));
    return out + (sums_.size() + kBy - 1) / kBy;
  }

  // Sums the rows below one coarse row, voxel by voxel along x; returns the number of rows.
  int sumRows(const Below& ys, const Below& zs) {
    std::fill(sums_.begin(), sums_.end(), Sum(0));
    std::fill(counts_.begin(), counts_.end(), 0);
    for (std::int64_t z = zs.lo; z < zs.hi; ++z) {
      for (std::int64_t y = ys.lo; y < ys.hi; ++y) {
        const T* const row =
            voxels_ + ((z - box_.lo.z) * size_.y + (y - box_.lo.y)) * size_.x + (core_.lo.x - box_.lo.x);
        Sum* const sums = sums_.data();
        for (std::size_t i = 0; i < sums_.size(); ++i) {
          if constexpr (std::is_floating_point_v<T>) {
            const bool exists = !std::isnan(row[i]);
            sums[i] += exists ? static_cast<Sum>(row[i]) : Sum(0);
            counts_[i] += exists ? 1 : 0;
          } else {
            sums[i] += row[i];
          }
        }
      }
    }
    return static_cast<int>((ys.hi - ys.lo) * (zs.hi - zs.lo));
  }

  const T* voxels_;
  VoxelBox box_, core_;
  Extent3 size_, by_;
  std::vector<Sum> sums_;
  std::vector<int> counts_;
};

// Returns the most frequent label; on a tie the smallest label that is not 0.
template <class T>
T mostFrequent(std::span<T> labels) {
  if (std::count(labels.begin(), labels.end(), labels.front()) == std::ssize(labels)) return labels.front();
  std::sort(labels.begin(), labels.end());
  T best = labels.front();
  std::size_t most = 0;
  for (auto first = labels.begin(); first != labels.end();) {
    const auto end = std::upper_bound(first, labels.end(), *first);
    const auto count = static_cast<std::size_t>(end - first);
    if (count > most || (count == most && best == 0)) best = *first, most = count;
    first = end;
  }
  return best;
}

template <class T>
void chooseLabels(const T* voxels, const VoxelBox& box, const VoxelBox& core, const Extent3& by, const VoxelBox& coarse,
                  T* out) {
  const Extent3 size = box.extent();
  for (std::int64_t z = coarse.lo.z; z < coarse.hi.z; ++z) {
    for (std::int64_t y = coarse.lo.y; y < coarse.hi.y; ++y) {
      for (std::int64_t x = coarse.lo.x; x < coarse.hi.x; ++x) {
        const Below xs = below(x, by.x, core.hi.x), ys = below(y, by.y, core.hi.y), zs = below(z, by.z, core.hi.z);
        std::array<T, 8> labels{};
        std::size_t count = 0;
        for (std::int64_t k = zs.lo; k < zs.hi; ++k) {
          for (std::int64_t j = ys.lo; j < ys.hi; ++j) {
            const T* const row = voxels + ((k - box.lo.z) * size.y + (j - box.lo.y)) * size.x - box.lo.x;
            for (std::int64_t i = xs.lo; i < xs.hi; ++i) labels[count++] = row[i];
          }
        }
        *out++ = mostFrequent(std::span(labels).first(count));
      }
    }
  }
}

// The fixed part of a half brick's bytes; voxels and cells follow.
struct PartHead {
  VoxelBox box, cell_box;
  ValueRange support;
  std::uint64_t voxel_bytes = 0;
};

HalfBrick emptyPart(const BrickDesc& fine, const Extent3& by) {
  HalfBrick part;
  part.box = coarseBox(fine.core(), by);
  part.voxels.resize(static_cast<std::size_t>(part.box.count()) * sizeOf(fine.type));
  part.cell_box = cellsOf(part.box);
  part.cells.resize(static_cast<std::size_t>(part.cell_box.count()));
  return part;
}

}  // namespace

std::uint64_t HalfBrick::bytesOf(const Extent3& voxels, std::uint64_t voxel_bytes) {
  const std::int64_t cells = cellsOf(boxOf(voxels)).count();
  const std::uint64_t bytes = sizeof(HalfBrick) + static_cast<std::uint64_t>(voxels.count()) * voxel_bytes +
                              static_cast<std::uint64_t>(cells) * sizeof(ValueRange);
  // measured: parts lie between the buffers of bricks, which are allocated and freed all the time
  return bytes + bytes / 4;
}

VoxelBox cellCubeOf(const BrickDesc& brick) {
  const VoxelCoord lo = cellsOf(brick.core()).lo;
  const std::int64_t edge = brick.brick_size / kCellSize;
  return {lo, {lo.x + edge, lo.y + edge, lo.z + edge}};
}

void includeCells(std::span<const ValueRange> from, const VoxelBox& from_box, std::span<ValueRange> to,
                  const VoxelBox& to_box) {
  forEachCoord(intersection(from_box, to_box),
               [&](const VoxelCoord& cell) { to[offsetIn(to_box, cell)].include(from[offsetIn(from_box, cell)]); });
}

HalfBrick coarsePartOf(const BrickDesc& fine, std::span<const std::byte> voxels, const VoxelBox& box,
                       const BrickRanges& ranges, const Extent3& by, Coarse coarse) {
  HalfBrick part = emptyPart(fine, by);
  const VoxelBox core = fine.core();
  withVoxelType(fine.type, [&]<class T>(std::type_identity<T>) {
    const T* const from = reinterpret_cast<const T*>(voxels.data());
    T* const to = reinterpret_cast<T*>(part.voxels.data());
    if (coarse == Coarse::kMean)
      Halver<T>(from, box, core, by).run(part.box, to);
    else
      chooseLabels(from, box, core, by, part.box, to);
  });
  const VoxelBox cube = cellCubeOf(fine);
  forEachCoord(cellsOf(core), [&](const VoxelCoord& cell) {
    const VoxelCoord coarser = {cell.x / by.x, cell.y / by.y, cell.z / by.z};
    part.cells[offsetIn(part.cell_box, coarser)].include(ranges.cells[offsetIn(cube, cell)]);
  });
  part.support = ranges.support;
  return part;
}

HalfBrick constantPartOf(const BrickDesc& fine, double value, const Extent3& by) {
  HalfBrick part = emptyPart(fine, by);
  withVoxelType(fine.type, [&]<class T>(std::type_identity<T>) {
    std::fill_n(reinterpret_cast<T*>(part.voxels.data()), part.box.count(), static_cast<T>(value));
  });
  part.support = {value, value};
  std::fill(part.cells.begin(), part.cells.end(), part.support);
  return part;
}

HalfBrick cropped(const HalfBrick& part, const VoxelBox& box) {
  const VoxelBox common = intersection(part.box, box);
  if (common == part.box) return part;
  const auto voxel_bytes = part.voxels.size() / static_cast<std::size_t>(part.box.count());
  HalfBrick out{common, {}, {}, {}, part.support};
  out.voxels.resize(static_cast<std::size_t>(common.count()) * voxel_bytes);
  copyCommon(part.voxels, part.box, out.voxels, common, voxel_bytes);
  return out;
}

std::vector<std::byte> bytesOf(const HalfBrick& part) {
  const PartHead head{part.box, part.cell_box, part.support, part.voxels.size()};
  const auto cells = std::as_bytes(std::span(part.cells));
  std::vector<std::byte> out;
  out.reserve(sizeof head + part.voxels.size() + cells.size());
  appendValue(out, head);
  out.insert(out.end(), part.voxels.begin(), part.voxels.end());
  out.insert(out.end(), cells.begin(), cells.end());
  return out;
}

HalfBrick partFrom(std::span<const std::byte> bytes, const std::filesystem::path& place) {
  ByteTaker taker{bytes};
  const auto head = taker.take<PartHead>();
  HalfBrick part{head.box, {}, head.cell_box, {}, head.support};
  const std::span<const std::byte> voxels = taker.takeBytes(head.voxel_bytes);
  if (!taker.ok || taker.left.size() != static_cast<std::uint64_t>(part.cell_box.count()) * sizeof(ValueRange))
    throw Error(ErrorCode::kDamaged, place, "", "is no part of a brick; run the conversion again");
  part.voxels.assign(voxels.begin(), voxels.end());
  part.cells.resize(taker.left.size() / sizeof(ValueRange));
  if (!part.cells.empty()) std::memcpy(part.cells.data(), taker.left.data(), taker.left.size());
  return part;
}

}  // namespace kiln
