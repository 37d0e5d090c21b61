// Masks as integers, lane packing and table look-up, for cases in which Highway's own operations are slow. Compiled
// once for each instruction set; hence no #pragma once.
// AVX2: a gather is as slow as eight loads.
// Highway 1.0.3 (Debian 12): Compress copies its table to the stack at each call; with AVX2's table of 1 KiB this took
// a quarter of a frame of the pixel lattice.
#if defined(KILN_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_LANES_INL_H
#undef KILN_LANES_INL_H
#else
#define KILN_LANES_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "engine/shared/sample_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

// Returns the mask as an integer, one bit per lane. requires: at most 16 lanes.
template <class Tag>
HWY_INLINE std::uint32_t bitsOf(Tag d, hn::Mask<Tag> mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  return static_cast<std::uint32_t>(bytes[0] | bytes[1] << 8);
}

#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_SSE4

// For each set of up to eight lanes, the lane numbers in ascending order.
struct LaneOrders {
  alignas(64) std::uint8_t of[256][8];
};
constexpr LaneOrders kLaneOrders = [] {
  LaneOrders out{};
  for (int lanes = 0; lanes < 256; ++lanes) {
    int n = 0;
    for (int lane = 0; lane < 8; ++lane) {
      if ((lanes >> lane & 1) != 0) out.of[lanes][n++] = static_cast<std::uint8_t>(lane);
    }
  }
  return out;
}();

// Moves the lanes of a mask to the front of a vector; lanes behind them are undefined. Reusable for any number of
// vectors.
class Packing {
 public:
  HWY_INLINE explicit Packing(M lanes) {
    const DI di;
    order_ = hn::PromoteTo(di, hn::LoadU(hn::Rebind<std::uint8_t, DI>(), kLaneOrders.of[bitsOf(D(), lanes)]));
  }
  HWY_INLINE V operator()(V v) const { return hn::TableLookupLanes(v, hn::IndicesFromVec(D(), order_)); }
  HWY_INLINE VI operator()(VI v) const { return hn::TableLookupLanes(v, hn::IndicesFromVec(DI(), order_)); }

 private:
  VI order_;
};

#else

class Packing {
 public:
  HWY_INLINE explicit Packing(M lanes) : lanes_(lanes) {}
  HWY_INLINE V operator()(V v) const { return hn::Compress(v, lanes_); }
  HWY_INLINE VI operator()(VI v) const { return hn::Compress(v, hn::RebindMask(DI(), lanes_)); }

 private:
  M lanes_;
};

#endif

// Looks up entries of a table of sixteen readable entries. requires: 0 <= index < 16.
template <class DT>
HWY_INLINE hn::Vec<DT> lookUp(DT d, const hn::TFromD<DT>* HWY_RESTRICT table, VI index) {
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
  return hn::TableLookupLanes(hn::LoadU(d, table), hn::IndicesFromVec(d, index));
#elif HWY_TARGET == HWY_AVX2
  const DI di;
  const auto within = hn::IndicesFromVec(d, hn::And(index, hn::Set(di, 7)));
  const auto lower = hn::TableLookupLanes(hn::LoadU(d, table), within);
  const auto upper = hn::TableLookupLanes(hn::LoadU(d, table + 8), within);
  return hn::IfThenElse(hn::RebindMask(d, hn::Gt(index, hn::Set(di, 7))), upper, lower);
#else
  return hn::GatherIndex(d, table, index);
#endif
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
