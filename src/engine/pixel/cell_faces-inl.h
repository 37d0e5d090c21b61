// Points of a cell's rays on cut faces. Compiled once for each instruction set; hence no #pragma once.
// Method. The depth of a ray's point (cut_faces.h) selects the zone and the slab; the faces of cells divide the zone as
// for samples. Each point is therefore in one cell.
#if defined(KILN_CELL_FACES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_CELL_FACES_INL_H
#undef KILN_CELL_FACES_INL_H
#else
#define KILN_CELL_FACES_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "engine/pixel/cell_places-inl.h"
#include "engine/pixel/cut_faces.h"
#include "engine/shared/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

class CellFaces {
 public:
  CellFaces(const CellPlaces& places, const RaySampling& rays, const SlabContext& context, const CellInput& in,
            CellSamples& samples)
      : p_(places), r_(rays), faces_(*context.look().faces), zone_(context.zone()), in_(in), s_(samples) {}

  // Finds the points of rays of open pixels. Calls cast(n) for batches of n points, with their CellSamples: index,
  // kept_code, at, offset, fraction. `cast` may close pixels.
  template <class Cast>
  void find(const Cast& cast) {
    std::size_t found = 0;
    const auto castFound = [&] {
      const std::size_t kept = keepInside(found);
      if (kept > 0) cast(kept);
      found = 0;
    };
    for (int y = in_.rect.y0; y < in_.rect.y1; ++y) {
      for (int x = r_.firstRay(in_.rect.x0, y); x < in_.rect.x1; x += r_.rayStride()) {
        const std::int32_t pixel = (x - in_.rect.x0) + ((y - in_.rect.y0) << CellPlaces::kPixelBits);
        if (p_.pixelOf(pixel)[3] == 1.0f) continue;
        const double depth = faces_.depthAt(x, y);
        if (!(depth >= zone_.near && depth < zone_.far)) continue;
        const double slabs = (depth - zone_.near) / zone_.thickness;
        const int slab = std::clamp(static_cast<int>(slabs), r_.first, r_.end - 1);
        s_.kept_code[found] = pixel + (slab << CellPlaces::kSlabBits);
        s_.at[found] = static_cast<float>(slabs - 0.5 - static_cast<double>(r_.middle));
        if (++found == CellSamples::kMost) castFound();
      }
    }
    if (found > 0) castFound();
  }

 private:
  // Keeps the points inside the cell and the drawn part.
  HWY_NOINLINE std::size_t keepInside(std::size_t count) {
    const D d;
    const DI di;
    std::size_t kept = 0;
    for (std::size_t n = 0; n < count; n += hn::Lanes(d)) {
      const VI code = hn::Load(di, s_.kept_code + n);
      const V at = hn::Load(d, s_.at + n);
      const CellPlaces::Where w = p_.slabOf(code);
      V enter = hn::Set(d, -CellPlaces::kFar), leave = hn::Set(d, CellPlaces::kFar);
      p_.cutToCell(w, enter, leave);
      const M inside = hn::And(lanesBefore(n, count), hn::And(hn::Le(enter, at), hn::Lt(at, leave)));
      const Packing packed(inside);
      hn::StoreU(packed(code), di, s_.kept_code + kept);
      hn::StoreU(packed(at), d, s_.at + kept);
      kept += hn::CountTrue(d, inside);
    }
    for (std::size_t n = 0; n < kept; n += hn::Lanes(d)) {
      p_.placeAt(n, p_.slabOf(hn::Load(di, s_.kept_code + n)), hn::Load(d, s_.at + n), s_);
      hn::Store(hn::Iota(di, static_cast<int>(n)), di, s_.index + n);
    }
    return kept;
  }

  const CellPlaces& p_;
  const RaySampling& r_;
  const CutFaces& faces_;
  const SlabZone& zone_;
  const CellInput& in_;
  CellSamples& s_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
