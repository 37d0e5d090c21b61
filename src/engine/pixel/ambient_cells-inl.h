// Interpolates between cells of the grid of ambient occlusion, two bytes of a cell at a time, in numbers of 16 bits.
// Every instruction set returns equal bits. Compiled once for each instruction set; hence no #pragma once.
#if defined(KILN_AMBIENT_CELLS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_AMBIENT_CELLS_INL_H
#undef KILN_AMBIENT_CELLS_INL_H
#else
#define KILN_AMBIENT_CELLS_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "engine/shared/sample_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

// Two numbers of 16 bits in a lane.
#if HWY_TARGET == HWY_SCALAR
class Halves {
 public:
  // requires: numbers of 16 bits.
  static HWY_INLINE Halves of(VI lower, VI upper) { return {lower, upper}; }
  // The lower bytes of the halves of words, and the upper bytes. unit: 1 / 256.
  static HWY_INLINE Halves lowerBytes(VI words) { return bytesFrom(words, 24, 8); }
  static HWY_INLINE Halves upperBytes(VI words) { return bytesFrom(words, 16, 0); }
  // `a_share`, `b_share`: unit: 1 / 32768.
  static HWY_INLINE Halves mix(const Halves& a, const Halves& a_share, const Halves& b, const Halves& b_share) {
    const auto sum = [](VI p, VI p_share, VI q, VI q_share) {
      return hn::Add(product(p, p_share), product(q, q_share));
    };
    return {sum(a.lower_, a_share.lower_, b.lower_, b_share.lower_),
            sum(a.upper_, a_share.upper_, b.upper_, b_share.upper_)};
  }
  HWY_INLINE VI lower() const { return lower_; }
  HWY_INLINE VI upper() const { return upper_; }

 private:
  HWY_INLINE Halves(VI lower, VI upper) : lower_(lower), upper_(upper) {}
  static HWY_INLINE Halves bytesFrom(VI words, int lower, int upper) {
    const auto byte = [&](int left) { return hn::ShiftLeft<8>(hn::ShiftRight<24>(hn::ShiftLeftSame(words, left))); };
    return {byte(lower), byte(upper)};
  }
  static HWY_INLINE VI product(VI a, VI share) {
    return hn::ShiftRight<15>(hn::Add(hn::Mul(a, share), hn::Set(DI(), 1 << 14)));
  }
  VI lower_, upper_;
};
#else
class Halves {
 public:
  // requires: numbers of 16 bits.
  static HWY_INLINE Halves of(VI lower, VI upper) {
    const DI di;
    return hn::BitCast(D16(), hn::Or(hn::And(lower, hn::Set(di, 0xffff)), hn::ShiftLeft<16>(upper)));
  }
  // The lower bytes of the halves of words, and the upper bytes. unit: 1 / 256.
  static HWY_INLINE Halves lowerBytes(VI words) { return hn::ShiftLeft<8>(hn::BitCast(D16(), words)); }
  static HWY_INLINE Halves upperBytes(VI words) {
    return hn::And(hn::BitCast(D16(), words), hn::Set(D16(), std::int16_t{-256}));
  }
  // `a_share`, `b_share`: unit: 1 / 32768.
  static HWY_INLINE Halves mix(const Halves& a, const Halves& a_share, const Halves& b, const Halves& b_share) {
    return hn::Add(hn::MulFixedPoint15(a.both_, a_share.both_), hn::MulFixedPoint15(b.both_, b_share.both_));
  }
  HWY_INLINE VI lower() const { return hn::ShiftRight<16>(hn::ShiftLeft<16>(hn::BitCast(DI(), both_))); }
  HWY_INLINE VI upper() const { return hn::ShiftRight<16>(hn::BitCast(DI(), both_)); }

 private:
  using D16 = hn::Repartition<std::int16_t, D>;
  HWY_INLINE Halves(hn::Vec<D16> both) : both_(both) {}
  hn::Vec<D16> both_;
};
#endif

// The position of samples between two cells.
class CellShare {
 public:
  // requires: 0 <= after <= 1.
  HWY_INLINE explicit CellShare(V after)
      : CellShare(hn::NearestInt(hn::Mul(after, hn::Set(D(), static_cast<float>(kOne))))) {}
  HWY_INLINE Halves mix(const Halves& here, const Halves& after) const {
    return Halves::mix(here, here_, after, after_);
  }
  // Sum of the weights of eight cells: the shares along an axis sum to 32767 / 32768.
  static constexpr float kWhole = (32767.0f / 32768) * (32767.0f / 32768) * (32767.0f / 32768);

 private:
  static constexpr std::int32_t kOne = 32767;
  HWY_INLINE explicit CellShare(VI after) : here_(twice(hn::Sub(hn::Set(DI(), kOne), after))), after_(twice(after)) {}
  static HWY_INLINE Halves twice(VI share) { return Halves::of(share, share); }
  Halves here_, after_;
};

// Four signed bytes of cells, from the lowest. unit: 1 / 256.
struct CellBytes {
  Halves even, odd;
  static HWY_INLINE CellBytes of(VI cells) { return {Halves::lowerBytes(cells), Halves::upperBytes(cells)}; }
  static HWY_INLINE CellBytes between(const CellBytes& here, const CellBytes& after, const CellShare& share) {
    return {share.mix(here.even, after.even), share.mix(here.odd, after.odd)};
  }
};

// Cells, and the next of each in its row.
struct CellPair {
  VI here, after;
};
// The eight cells around each sample: pairs in four rows, read one by one, because gathers are slower.
class CellRows {
 public:
  // `first`: places of the cells before the samples; `width`, `plane`: distance of cells along y and z.
  HWY_INLINE CellRows(const std::int32_t* cells, VI first, std::int32_t width, std::int32_t plane) {
    alignas(64) std::int32_t places[hn::MaxLanes(D())];
    hn::Store(first, DI(), places);
    for (std::size_t i = 0; i < hn::Lanes(D()); ++i) {
      const std::int32_t* const at = cells + places[i];
      std::memcpy(rows_[0] + 2 * i, at, sizeof(std::int64_t));
      std::memcpy(rows_[1] + 2 * i, at + width, sizeof(std::int64_t));
      std::memcpy(rows_[2] + 2 * i, at + plane, sizeof(std::int64_t));
      std::memcpy(rows_[3] + 2 * i, at + plane + width, sizeof(std::int64_t));
    }
  }
  HWY_INLINE CellPair row(std::size_t of) const {
    CellPair out;
    hn::LoadInterleaved2(DI(), rows_[of], out.here, out.after);
    return out;
  }

 private:
  alignas(64) std::int32_t rows_[4][2 * hn::MaxLanes(D())];
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
