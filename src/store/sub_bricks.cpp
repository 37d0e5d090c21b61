#include "store/sub_bricks.h"

#include <algorithm>
#include <cmath>

#include "store/box_ranges.h"
#include "store/minmax_octree.h"

namespace kiln {
namespace {

constexpr int kSubSteps = 255;

// The value that a byte stands for. The ends are the support's own, infinities included.
double valueOfStep(int step, const ValueRange& support) {
  if (step == 0) return support.lo;
  if (step == kSubSteps) return support.hi;
  return support.lo + (support.hi - support.lo) * (step / static_cast<double>(kSubSteps));
}

// The last step whose value does not exceed `value`, or nearly so.
int stepBelow(double value, const ValueRange& support) {
  const double share = (value - support.lo) / (support.hi - support.lo);
  if (!(share >= 0 && share <= 1) || !std::isfinite(support.hi - support.lo)) return 0;
  int step = static_cast<int>(std::floor(share * kSubSteps));
  while (step > 0 && valueOfStep(step, support) > value) --step;
  return step;
}

int stepAbove(double value, const ValueRange& support) {
  const double share = (value - support.lo) / (support.hi - support.lo);
  if (!(share >= 0 && share <= 1) || !std::isfinite(support.hi - support.lo)) return kSubSteps;
  int step = static_cast<int>(std::ceil(share * kSubSteps));
  while (step < kSubSteps && valueOfStep(step, support) < value) ++step;
  return step;
}

// Sub-brick i of an axis: [lo, hi) of the core.
VoxelSpan spanOf(std::int64_t i, std::int64_t core_lo, std::int64_t core_hi, std::int64_t size) {
  return {core_lo + i * size, std::min(core_lo + (i + 1) * size, core_hi)};
}

}  // namespace

std::int64_t subBrickSize(std::int64_t brick_size) { return std::max(kCellSize, brick_size / kSubBricks); }

VoxelBox subBrickOf(const VoxelBox& core, std::int64_t brick_size, const VoxelCoord& at) {
  VoxelBox out;
  for (int axis = 0; axis < 3; ++axis) {
    const VoxelSpan span = spanOf(at[axis], core.lo[axis], core.hi[axis], subBrickSize(brick_size));
    out.lo[axis] = span.lo;
    out.hi[axis] = span.hi;
  }
  return out;
}

std::vector<ValueRange> subBrickRanges(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& box,
                                       const VoxelBox& core, std::int64_t brick_size) {
  std::array<std::vector<VoxelSpan>, 3> spans;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t lo = core.lo[axis], hi = core.hi[axis];
    for (std::int64_t i = 0; i < kSubBricks; ++i) {
      VoxelSpan span = spanOf(i, lo, hi, subBrickSize(brick_size));
      if (span.lo < span.hi) {
        span.lo = span.lo == lo ? box.lo[axis] : std::max(span.lo - kSubBrickReach, box.lo[axis]);
        span.hi = span.hi == hi ? box.hi[axis] : std::min(span.hi + kSubBrickReach, box.hi[axis]);
      } else {
        span = {box.lo[axis], box.lo[axis]};
      }
      spans[static_cast<std::size_t>(axis)].push_back(span);
    }
  }
  return boxRanges(voxels, type, box, spans);
}

SubRanges::SubRanges(std::span<const ValueRange> ranges, const ValueRange& support) {
  for (std::size_t i = 0; i < kCount; ++i) {
    lo_[i] = static_cast<std::uint8_t>(ranges[i].empty() ? kSubSteps : stepBelow(ranges[i].lo, support));
    hi_[i] = static_cast<std::uint8_t>(ranges[i].empty() ? 0 : stepAbove(ranges[i].hi, support));
  }
}

ValueRange SubRanges::at(std::size_t i, const ValueRange& support) const {
  if (lo_[i] > hi_[i]) return {};
  return {valueOfStep(lo_[i], support), valueOfStep(hi_[i], support)};
}

}  // namespace kiln
