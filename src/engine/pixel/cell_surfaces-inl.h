// Crossings of a cell's rays with iso-surfaces. Compiled once for each instruction set; hence no #pragma once.
// Problem. Each crossing of a ray with a surface must be found once, whatever the cells, and as exactly as the
// interpolation allows.
// Method. The borders of slabs and the faces of cells divide a ray into pieces. A piece that bends towards a surface
// beyond both of its ends is divided at its farthest value. The field is evaluated at both ends of a piece; a piece
// whose ends lie on two sides of a surface has one crossing with it, found by the Illinois method.
// Invariant. A position on a ray has equal bits in all cells, slabs and zones that meet there, and so has its value.
// The values along a ray are hence one sequence, and all crossings of the sequence are found, each in one piece.
// Source: Dowell and Jarratt 1971 (Illinois method); Hadwiger et al. 2005 (refinement in a sampling interval).
// Differs: pieces end at faces of cells. Two crossings of one surface within an eighth of a slab cancel.
// Cost: three values for each piece near a surface, kParts - 2 for each bent piece, kRefinements for each crossing.
#if defined(KILN_CELL_SURFACES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_CELL_SURFACES_INL_H
#undef KILN_CELL_SURFACES_INL_H
#else
#define KILN_CELL_SURFACES_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "engine/pixel/cell_places-inl.h"
#include "engine/shared/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

template <class Field>
class CellSurfaces {
 public:
  CellSurfaces(const CellPlaces& places, const RaySampling& rays, const SampleLattice& lattice, const CellInput& in,
               Field& field, CellSamples& samples)
      : p_(places), r_(rays), l_(lattice), in_(in), field_(field), s_(samples) {}

  // Finds the crossings in the slabs of the first `count` codes of CellSamples::code, in the order of the codes. Calls
  // cast(n) for batches of n crossings, with their CellSamples: index, kept_code, at, offset, fraction, entry, opacity.
  template <class Cast>
  void find(std::size_t count, const Cast& cast) {
    findPieces(count);
    findTurns(count);
    const std::size_t crossed = keepCrossed(count);
    std::size_t found = 0;
    const auto castFound = [&] {
      if (found > 0) refine(found), cast(found);
      found = 0;
    };
    const auto addBetween = [&](std::size_t piece, const End& first, const End& last) {
      // Surfaces lie between the ends in the order of their values.
      const int from = rankOf(first.value), to = rankOf(last.value), step = from < to ? 1 : -1;
      for (int rank = from; rank != to; rank += step) {
        if (found == CellSamples::kMost) castFound();
        addCrossing(s_.code[piece], first, last, step > 0 ? rank : rank - 1, found++);
      }
    };
    for (std::size_t n = 0; n < crossed; ++n) {
      const End turn = {s_.turn[n], s_.value_turn[n]};
      addBetween(n, {s_.begin[n], s_.value_begin[n]}, turn);
      addBetween(n, turn, {s_.end[n], s_.value_end[n]});
    }
    castFound();
  }

 private:
  // Evaluations for a crossing after the two ends of its piece (figures: decisions/crossings.md).
  static constexpr int kRefinements = 12;
  // Parts of a bent piece between which its farthest value is looked for (figures: decisions/bent-pieces.md).
  static constexpr int kParts = 8;

  // An end of a part of a ray, and the value there.
  struct End {
    float at, value;
  };

  // Computes the ends of the slabs' parts inside the cell, and the values there. Slabs without a part have equal ends.
  HWY_NOINLINE void findPieces(std::size_t count) {
    const D d;
    const DI di;
    const V half = hn::Set(d, 0.5f);
    for (std::size_t n = 0; n < count; n += hn::Lanes(d)) {
      const CellPlaces::Where w = p_.slabOf(hn::Load(di, s_.code + n));
      V enter = hn::Sub(w.t, half), leave = hn::Add(w.t, half);
      const M first = hn::Eq(w.t, hn::Set(d, -r_.middle));
      enter = hn::Sub(enter, hn::IfThenElseZero(first, hn::Set(d, r_.overlap)));
      p_.cutToCell(w, enter, leave);
      const M some = hn::Lt(enter, leave);
      enter = hn::IfThenElse(some, enter, w.t), leave = hn::IfThenElse(some, leave, w.t);
      hn::Store(enter, d, s_.begin + n);
      hn::Store(leave, d, s_.end + n);
      placeAt(n, w, enter);
    }
    field_.interpolate(count);
    for (std::size_t n = 0; n < count; n += hn::Lanes(d)) hn::Store(field_.values(n), d, s_.value_begin + n);
    for (std::size_t n = 0; n < count; n += hn::Lanes(d))
      placeAt(n, p_.slabOf(hn::Load(di, s_.code + n)), hn::Load(d, s_.end + n));
    field_.interpolate(count);
    for (std::size_t n = 0; n < count; n += hn::Lanes(d)) hn::Store(field_.values(n), d, s_.value_end + n);
  }

  // Finds the turn of each piece that may cross a surface twice: the place of the value that is farthest beyond both
  // ends. The turn of each other piece is its end.
  HWY_NOINLINE void findTurns(std::size_t count) {
    const std::size_t bent = keepBent(count);
    if (bent > 0) moveToFarthest(bent);
    for (std::size_t n = 0; n < bent; ++n) {
      const auto piece = static_cast<std::size_t>(s_.index[n]);
      s_.turn[piece] = s_.at[n], s_.value_turn[piece] = s_.excess[0][n];
    }
  }

  // Keeps the pieces that may bend across a surface, with their middles as turns. Returns their number.
  HWY_INLINE std::size_t keepBent(std::size_t count) {
    const D d;
    const DI di;
    const V half = hn::Set(d, 0.5f);
    for (std::size_t n = 0; n < count; n += hn::Lanes(d)) {
      const V begin = hn::Load(d, s_.begin + n), end = hn::Load(d, s_.end + n);
      hn::Store(end, d, s_.turn + n);
      hn::Store(hn::Load(d, s_.value_end + n), d, s_.value_turn + n);
      placeAt(n, p_.slabOf(hn::Load(di, s_.code + n)), hn::Mul(half, hn::Add(begin, end)));
    }
    field_.interpolate(count);
    std::size_t bent = 0;
    for (std::size_t n = 0; n < count; n += hn::Lanes(d)) {
      const V first = hn::Load(d, s_.value_begin + n), last = hn::Load(d, s_.value_end + n), middle = field_.values(n);
      const V least = hn::Min(first, last), most = hn::Max(first, last), twice = hn::Add(middle, middle);
      // A piece that bends to one side stays within the lines from its ends through its middle.
      const V above = hn::Sub(twice, least), below = hn::Sub(twice, most);
      M turns = hn::Lt(first, first);
      for (int surface = 0; surface < l_.surfaces; ++surface) {
        const V value = hn::Set(d, l_.surface_values[surface]);
        turns = hn::Or(turns, hn::Or(hn::And(hn::Lt(most, value), hn::Ge(above, value)),
                                     hn::And(hn::Ge(least, value), hn::Lt(below, value))));
      }
      const V begin = hn::Load(d, s_.begin + n), end = hn::Load(d, s_.end + n);
      turns = hn::And(turns, hn::And(lanesBefore(n, count), hn::Lt(begin, end)));
      if (hn::AllFalse(d, turns)) continue;
      const Packing packed(turns);
      hn::StoreU(packed(hn::Iota(di, static_cast<int>(n))), di, s_.index + bent);
      hn::StoreU(packed(hn::Load(di, s_.code + n)), di, s_.kept_code + bent);
      hn::StoreU(packed(begin), d, s_.bracket[0] + bent), hn::StoreU(packed(end), d, s_.bracket[1] + bent);
      hn::StoreU(packed(hn::Mul(half, hn::Add(begin, end))), d, s_.at + bent);
      hn::StoreU(packed(middle), d, s_.excess[0] + bent);
      hn::StoreU(packed(hn::Sub(twice, hn::Add(first, last))), d, s_.excess[1] + bent);
      bent += hn::CountTrue(d, turns);
    }
    return bent;
  }

  // Moves the turns of bent pieces to the farthest of the values between their parts.
  HWY_INLINE void moveToFarthest(std::size_t bent) {
    const D d;
    const DI di;
    const V zero = hn::Zero(d);
    for (int part = 1; part < kParts; ++part) {
      if (part == kParts / 2) continue;
      const V share = hn::Set(d, static_cast<float>(part) / kParts);
      const auto place = [&](std::size_t n) {
        const V begin = hn::Load(d, s_.bracket[0] + n);
        return hn::Add(begin, hn::Mul(share, hn::Sub(hn::Load(d, s_.bracket[1] + n), begin)));
      };
      for (std::size_t n = 0; n < bent; n += hn::Lanes(d))
        placeAt(n, p_.slabOf(hn::Load(di, s_.kept_code + n)), place(n));
      field_.interpolate(bent);
      for (std::size_t n = 0; n < bent; n += hn::Lanes(d)) {
        const V value = field_.values(n), farthest = hn::Load(d, s_.excess[0] + n);
        const M upwards = hn::Gt(hn::Load(d, s_.excess[1] + n), zero);
        const M farther =
            hn::Or(hn::And(upwards, hn::Gt(value, farthest)), hn::AndNot(upwards, hn::Lt(value, farthest)));
        hn::Store(hn::IfThenElse(farther, place(n), hn::Load(d, s_.at + n)), d, s_.at + n);
        hn::Store(hn::IfThenElse(farther, value, farthest), d, s_.excess[0] + n);
      }
    }
  }

  // Keeps the pieces that cross some surface. Returns their number.
  HWY_INLINE std::size_t keepCrossed(std::size_t count) {
    const D d;
    const DI di;
    std::size_t kept = 0;
    for (std::size_t n = 0; n < count; n += hn::Lanes(d)) {
      const V begin = hn::Load(d, s_.begin + n), end = hn::Load(d, s_.end + n);
      const V first = hn::Load(d, s_.value_begin + n), last = hn::Load(d, s_.value_end + n);
      const V turn = hn::Load(d, s_.turn + n), value_turn = hn::Load(d, s_.value_turn + n);
      M crossed = hn::Lt(first, first);
      for (int surface = 0; surface < l_.surfaces; ++surface) {
        const V value = hn::Set(d, l_.surface_values[surface]);
        const M inside = hn::Ge(value_turn, value);
        crossed = hn::Or(crossed, hn::Or(hn::Xor(hn::Ge(first, value), inside), hn::Xor(inside, hn::Ge(last, value))));
      }
      // NaN lies on no side.
      crossed = hn::And(crossed, hn::And(hn::Eq(first, first), hn::Eq(last, last)));
      crossed = hn::And(crossed, hn::And(lanesBefore(n, count), hn::Lt(begin, end)));
      if (hn::AllFalse(d, crossed)) continue;
      const Packing packed(crossed);
      hn::StoreU(packed(hn::Load(di, s_.code + n)), di, s_.code + kept);
      hn::StoreU(packed(begin), d, s_.begin + kept), hn::StoreU(packed(end), d, s_.end + kept);
      hn::StoreU(packed(first), d, s_.value_begin + kept), hn::StoreU(packed(last), d, s_.value_end + kept);
      hn::StoreU(packed(turn), d, s_.turn + kept), hn::StoreU(packed(value_turn), d, s_.value_turn + kept);
      kept += hn::CountTrue(d, crossed);
    }
    return kept;
  }

  // Number of surfaces that a value is inside of.
  HWY_INLINE int rankOf(float value) const {
    int out = 0;
    while (out < l_.surfaces && value >= l_.surface_values[out]) ++out;
    return out;
  }

  HWY_INLINE void addCrossing(std::int32_t code, const End& first, const End& last, int surface, std::size_t n) {
    const float value = l_.surface_values[surface];
    s_.kept_code[n] = code;
    s_.entry[n] = static_cast<float>(surface);
    s_.opacity[n] = l_.surface_opacities[surface];
    s_.bracket[0][n] = first.at, s_.bracket[1][n] = last.at;
    s_.excess[0][n] = first.value - value, s_.excess[1][n] = last.value - value;
    s_.moved[n] = 0;
  }

  // Moves the crossings from their brackets to the surfaces. `excess`: value less the surface's.
  HWY_NOINLINE void refine(std::size_t count) {
    const D d;
    const DI di;
    const V zero = hn::Zero(d), half = hn::Set(d, 0.5f);
    for (int i = 0; i <= kRefinements; ++i) {
      for (std::size_t n = 0; n < count; n += hn::Lanes(d)) {
        const V a = hn::Load(d, s_.bracket[0] + n), b = hn::Load(d, s_.bracket[1] + n);
        const V of_a = hn::Load(d, s_.excess[0] + n), of_b = hn::Load(d, s_.excess[1] + n);
        // Infinite values have no chord.
        V at = hn::Sub(b, hn::Mul(of_b, hn::Div(hn::Sub(b, a), hn::Sub(of_b, of_a))));
        at = hn::IfThenElse(hn::And(hn::Ge(at, a), hn::Le(at, b)), at, hn::Mul(half, hn::Add(a, b)));
        hn::Store(at, d, s_.at + n);
        placeAt(n, p_.slabOf(hn::Load(di, s_.kept_code + n)), at);
        hn::Store(hn::Iota(di, static_cast<int>(n)), di, s_.index + n);
      }
      if (i == kRefinements) return;
      field_.interpolate(count);
      for (std::size_t n = 0; n < count; n += hn::Lanes(d)) {
        const V value = hn::GatherIndex(d, l_.surface_values, surfaceOf(n, count));
        const V at = hn::Load(d, s_.at + n), excess = hn::Sub(field_.values(n), value);
        V of_a = hn::Load(d, s_.excess[0] + n), of_b = hn::Load(d, s_.excess[1] + n);
        const V moved = hn::Load(d, s_.moved + n);
        // The new end replaces the end on the same side. An end kept twice counts half, so that this end moves next.
        const M first = hn::Not(hn::Xor(hn::Ge(excess, zero), hn::Ge(of_a, zero)));
        of_b = hn::IfThenElse(hn::And(first, hn::Lt(moved, zero)), hn::Mul(half, of_b), of_b);
        of_a = hn::IfThenElse(hn::AndNot(first, hn::Gt(moved, zero)), hn::Mul(half, of_a), of_a);
        hn::Store(hn::IfThenElse(first, at, hn::Load(d, s_.bracket[0] + n)), d, s_.bracket[0] + n);
        hn::Store(hn::IfThenElse(first, hn::Load(d, s_.bracket[1] + n), at), d, s_.bracket[1] + n);
        hn::Store(hn::IfThenElse(first, excess, of_a), d, s_.excess[0] + n);
        hn::Store(hn::IfThenElse(first, of_b, excess), d, s_.excess[1] + n);
        hn::Store(hn::IfThenElse(first, hn::Set(d, -1.0f), hn::Set(d, 1.0f)), d, s_.moved + n);
      }
    }
  }

  // Indices of the surfaces of a vector of crossings; 0 beyond the last.
  HWY_INLINE VI surfaceOf(std::size_t n, std::size_t count) const {
    const D d;
    const DI di;
    return hn::ConvertTo(di, hn::IfThenElseZero(lanesBefore(n, count), hn::Load(d, s_.entry + n)));
  }

  HWY_INLINE void placeAt(std::size_t n, const CellPlaces::Where& w, V at) { p_.placeAt(n, w, at, s_); }

  const CellPlaces& p_;
  const RaySampling& r_;
  const SampleLattice& l_;
  const CellInput& in_;
  Field& field_;
  CellSamples& s_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
