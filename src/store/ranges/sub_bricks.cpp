#include "store/ranges/sub_bricks.h"

#include <algorithm>
#include <cmath>

#include "store/ranges/box_ranges.h"
#include "store/ranges/minmax_octree.h"

namespace kiln {
namespace {

constexpr int kSubSteps = 255;

// The value of a byte. The ends are exactly those of the support, including infinities.
double valueOfStep(int step, const ValueRange& support) {
  if (step == 0) return support.lo;
  if (step == kSubSteps) return support.hi;
  return support.lo + (support.hi - support.lo) * (step / static_cast<double>(kSubSteps));
}

// Returns the greatest step whose value does not exceed `value`, up to rounding.
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

// Edge of a sub-brick. unit: voxels.
std::int64_t sizeOf(std::int64_t brick_size, int along) { return std::max(kCellSize, brick_size / along); }

// Sub-brick i along an axis: [lo, hi) of the core.
VoxelSpan spanOf(std::int64_t i, std::int64_t core_lo, std::int64_t core_hi, std::int64_t size) {
  return {core_lo + i * size, std::min(core_lo + (i + 1) * size, core_hi)};
}

}  // namespace

int subBricksOf(std::int64_t brick_size) {
  return static_cast<int>(std::clamp<std::int64_t>(brick_size / kCellSize, 1, kMostSubBricks));
}

VoxelBox subBrickOf(const VoxelBox& core, std::int64_t brick_size, int along, const VoxelCoord& at) {
  VoxelBox out;
  for (int axis = 0; axis < 3; ++axis) {
    const VoxelSpan span = spanOf(at[axis], core.lo[axis], core.hi[axis], sizeOf(brick_size, along));
    out.lo[axis] = span.lo;
    out.hi[axis] = span.hi;
  }
  return out;
}

VoxelBox subBricksIn(const VoxelBox& part, const VoxelBox& core, std::int64_t brick_size, int along) {
  VoxelBox inside = intersection(part, core);
  for (int axis = 0; axis < 3; ++axis) inside.lo[axis] -= core.lo[axis], inside.hi[axis] -= core.lo[axis];
  return intersection(coarseBox(inside, sizeOf(brick_size, along)), boxOf({along, along, along}));
}

std::vector<ValueRange> subBrickRanges(std::span<const std::byte> voxels, VoxelType type, const VoxelBox& box,
                                       const VoxelBox& core, std::int64_t brick_size, int along) {
  std::array<std::vector<VoxelSpan>, 3> spans;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t lo = core.lo[axis], hi = core.hi[axis];
    for (std::int64_t i = 0; i < along; ++i) {
      VoxelSpan span = spanOf(i, lo, hi, sizeOf(brick_size, along));
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

SubRanges::SubRanges(int along, std::span<const ValueRange> ranges, const ValueRange& support)
    : along_(along), bytes_(bytesOf(along)) {
  for (std::size_t i = 0; i < count(); ++i) {
    bytes_[i] = static_cast<std::byte>(ranges[i].empty() ? kSubSteps : stepBelow(ranges[i].lo, support));
    bytes_[count() + i] = static_cast<std::byte>(ranges[i].empty() ? 0 : stepAbove(ranges[i].hi, support));
  }
}

SubRanges::SubRanges(int along, std::span<const std::byte> bytes) : along_(along), bytes_(bytes.begin(), bytes.end()) {}

void SubRanges::clear(std::size_t i) {
  bytes_[i] = static_cast<std::byte>(kSubSteps);
  bytes_[count() + i] = std::byte{0};
}

ValueRange SubRanges::at(std::size_t i, const ValueRange& support) const {
  const int lo = std::to_integer<int>(bytes_[i]), hi = std::to_integer<int>(bytes_[count() + i]);
  if (lo > hi) return {};
  return {valueOfStep(lo, support), valueOfStep(hi, support)};
}

}  // namespace kiln
