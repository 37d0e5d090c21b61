#include "support/volumes/empty_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/thread/parallel.h"

namespace kiln::test {

bool transparent(const TransferFunction& transfer_function, const ValueRange& range) {
  if (range.empty()) return true;
  if (transfer_function.at(range.lo).opacity > 0 || transfer_function.at(range.hi).opacity > 0) return false;
  return std::none_of(transfer_function.points.begin(), transfer_function.points.end(), [&](const TransferPoint& p) {
    return p.opacity > 0 && p.value >= range.lo && p.value <= range.hi;
  });
}

EmptyBlocks::EmptyBlocks(const Extent3& dims,
                         const std::function<double(std::int64_t, std::int64_t, std::int64_t)>& voxel,
                         std::int64_t reach, const TransferFunction& transfer_function)
    : dims_(dims), blocks_(brickLattice(dims, kBlock)), empty_(static_cast<std::size_t>(blocks_.count())) {
  parallelFor(static_cast<std::size_t>(blocks_.z), [&](std::size_t slice) {
    for (std::int64_t b = static_cast<std::int64_t>(slice) * blocks_.x * blocks_.y, n = 0; n < blocks_.x * blocks_.y;
         ++b, ++n) {
      // A voxel more on every side covers rounding of positions.
      const VoxelBox support =
          intersection(dilated(coreBox(brickAt(blocks_, b), kBlock, dims_), reach + 1), boxOf(dims_));
      ValueRange range;
      for (std::int64_t k = support.lo.z; k < support.hi.z; ++k) {
        for (std::int64_t j = support.lo.y; j < support.hi.y; ++j) {
          for (std::int64_t i = support.lo.x; i < support.hi.x; ++i) range.include(voxel(i, j, k));
        }
      }
      // The sum of rounded weights times values may exceed the range by a few units in the last place.
      const double slack = 1e-9 * std::max(std::abs(range.lo), std::abs(range.hi));
      if (!range.empty()) range = {range.lo - slack, range.hi + slack};
      empty_[static_cast<std::size_t>(b)] = transparent(transfer_function, range);
    }
  });
}

double EmptyBlocks::stepsToSkip(const glm::dvec3& index, const glm::dvec3& step) const {
  std::int64_t block[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double inside = std::clamp(index[axis], 0.0, static_cast<double>(dims_[axis] - 1));
    block[axis] = static_cast<std::int64_t>(inside) / kBlock;
  }
  if (empty_[static_cast<std::size_t>((block[2] * blocks_.y + block[1]) * blocks_.x + block[0])] == 0) return 0;
  double steps = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    // Outside the volume the nearest voxel is repeated: the outermost blocks have no end.
    const bool ends = step[axis] > 0 ? block[axis] + 1 < blocks_[axis] : step[axis] < 0 && block[axis] > 0;
    if (!ends) continue;
    const double wall = static_cast<double>(kBlock * (block[axis] + (step[axis] > 0 ? 1 : 0)));
    steps = std::min(steps, (wall - index[axis]) / step[axis]);
  }
  return std::max(1.0, std::floor(steps));
}

}  // namespace kiln::test
