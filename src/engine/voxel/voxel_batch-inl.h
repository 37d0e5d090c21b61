// Helpers shared by the kernels that handle a batch of footprints. Compiled once for each instruction set; hence no
// #pragma once.
#if defined(KILN_VOXEL_BATCH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_VOXEL_BATCH_INL_H
#undef KILN_VOXEL_BATCH_INL_H
#else
#define KILN_VOXEL_BATCH_INL_H
#endif

#include <hwy/highway.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "engine/shared/lanes-inl.h"
#include "engine/voxel/project_voxels.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

using DB = hn::CappedTag<std::int32_t, kVoxelBatch>;

// Calls f(n) for each set bit n.
template <class F>
HWY_INLINE void forEachBit(std::uint32_t bits, F f) {
  for (; bits != 0; bits &= bits - 1) f(static_cast<std::size_t>(std::countr_zero(bits)));
}

// Returns the bounding rectangle of the footprints whose bit is set.
HWY_INLINE PixelRect rectAround(const ProjectedVoxels& voxels, std::uint32_t of) {
  const DB d;
  const auto none = hn::Set(d, std::numeric_limits<std::int32_t>::max());
  auto x0 = none, y0 = none, x1 = hn::Not(none), y1 = hn::Not(none);
  for (std::size_t n = 0; n < kVoxelBatch; n += hn::Lanes(d)) {
    const auto bits = hn::Set(d, static_cast<std::int32_t>(of >> n));
    const auto asked = hn::TestBit(bits, hn::Shl(hn::Set(d, 1), hn::Iota(d, 0)));
    x0 = hn::Min(x0, hn::IfThenElse(asked, hn::Load(d, voxels.x0 + n), none));
    y0 = hn::Min(y0, hn::IfThenElse(asked, hn::Load(d, voxels.y0 + n), none));
    x1 = hn::Max(x1, hn::IfThenElse(asked, hn::Load(d, voxels.x1 + n), hn::Not(none)));
    y1 = hn::Max(y1, hn::IfThenElse(asked, hn::Load(d, voxels.y1 + n), hn::Not(none)));
  }
  return {hn::GetLane(hn::MinOfLanes(d, x0)), hn::GetLane(hn::MinOfLanes(d, y0)), hn::GetLane(hn::MaxOfLanes(d, x1)),
          hn::GetLane(hn::MaxOfLanes(d, y1))};
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
