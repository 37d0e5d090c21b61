// Rays that cross the volume between the middles of two slabs, at an edge of the volume. Compiled once for each
// instruction set; hence no #pragma once.
// Problem. Such rays have no sample; the outline of a volume of large voxels had teeth as deep as a slab.
// Method. The ray's chord in the volume gets one sample in its middle, for its whole length (CellPlaces::useChords).
// The middle selects the zone, the slab and the cell.
#if defined(KILN_CELL_CHORDS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_CELL_CHORDS_INL_H
#undef KILN_CELL_CHORDS_INL_H
#else
#define KILN_CELL_CHORDS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>

#include "engine/pixel/cell_places-inl.h"
#include "engine/shared/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

class CellChords {
 public:
  // requires: places.useChords(true).
  CellChords(const CellPlaces& places, const RaySampling& rays, const CellInput& in, CellSamples& samples)
      : p_(places), r_(rays), in_(in), s_(samples) {}

  // Calls cast(count) for the first `count` codes in CellSamples::code. `cast` may close pixels.
  template <class Cast>
  void find(const Cast& cast) {
    const DI di;
    const int stride = r_.rayStride();
    const VI column = hn::Mul(hn::Iota(di, 0), hn::Set(di, stride));
    std::size_t found = 0;
    for (int y = in_.rect.y0; y < in_.rect.y1; ++y) {
      for (int x = r_.firstRay(in_.rect.x0, y); x < in_.rect.x1; x += stride * static_cast<int>(hn::Lanes(di))) {
        const auto rays = static_cast<std::size_t>((in_.rect.x1 - x + stride - 1) / stride);
        const int first = (x - in_.rect.x0) + ((y - in_.rect.y0) << CellPlaces::kPixelBits);
        const VI code = hn::Add(column, hn::Set(di, first));
        found = keepShort(code, std::min(rays, hn::Lanes(di)), found);
        if (found < CellSamples::kMost) continue;
        cast(found);
        found = 0;
      }
    }
    if (found > 0) cast(found);
  }

 private:
  // Appends the codes of the rays, among the first `rays` of a vector, whose chord is in the cell and holds no middle.
  HWY_INLINE std::size_t keepShort(VI code, std::size_t rays, std::size_t found) {
    const D d;
    const DI di;
    const CellPlaces::Where w = p_.sampleOf(code);
    const CellPlaces::Span chord = p_.inVolume(w);
    const V middle = hn::Set(d, r_.middle);
    const V least = hn::Set(d, static_cast<float>(r_.first)), most = hn::Set(d, static_cast<float>(r_.end));
    M kept = hn::And(lanesBefore(0, rays), hn::Gt(w.slabs, hn::Zero(d)));
    kept = hn::And(kept, hn::Lt(chord.enter, chord.leave));
    // The chord has no middle of a slab of the zone, nor of the adjacent slabs in other zones.
    kept = hn::And(kept, hn::Ge(p_.slabFrom(chord.enter), p_.slabFrom(chord.leave)));
    kept = hn::And(kept, hn::Gt(chord.enter, hn::Set(d, r_.before)));
    kept = hn::And(kept, hn::Le(chord.leave, hn::Set(d, r_.after)));
    const V own = hn::Floor(hn::Add(hn::Add(w.t, middle), hn::Set(d, 0.5f)));
    kept = hn::And(kept, hn::And(hn::Ge(own, least), hn::Lt(own, most)));
    V enter = hn::Set(d, -CellPlaces::kFar), leave = hn::Set(d, CellPlaces::kFar);
    p_.cutToCell(w, enter, leave);
    kept = hn::And(kept, hn::And(hn::Le(enter, w.t), hn::Lt(w.t, leave)));
    if (hn::AllFalse(d, kept)) return found;
    const V slabs = hn::Min(hn::Max(own, least), most);
    const VI sample = hn::Add(code, hn::ShiftLeft<CellPlaces::kSlabBits>(hn::ConvertTo(di, slabs)));
    hn::StoreU(Packing(kept)(sample), di, s_.code + found);
    std::size_t open = found;
    for (std::size_t i = found; i < found + hn::CountTrue(d, kept); ++i) {
      if (p_.pixelOf(s_.code[i] & CellPlaces::kPixel)[3] != 1.0f) s_.code[open++] = s_.code[i];
    }
    return open;
  }

  const CellPlaces& p_;
  const RaySampling& r_;
  const CellInput& in_;
  CellSamples& s_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
