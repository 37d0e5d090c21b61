#include "store/brick_ranges.h"

namespace kiln {
namespace {

// Every interpolated value in the core lies in the range of the voxels this near: cubic interpolation reaches 2.
constexpr std::int64_t kSupport = 2;

}  // namespace

BrickRanges rangesOf(const BrickFrame& frame, std::span<const std::byte> voxels) {
  const VoxelBox core = frame.core(), box = frame.stored();
  BrickRanges out;
  out.cells = cellRanges(voxels, frame.type, box, core, static_cast<int>(frame.brick_size / kCellSize));
  for (const ValueRange& cell : out.cells) out.core.include(cell);
  out.support = rangeOf(voxels, frame.type, box, intersection(dilated(core, kSupport), box));
  return out;
}

}  // namespace kiln
