// Positions of a cell's rays and samples, computed from their codes. Compiled once for each instruction set; hence no
// #pragma once.
#if defined(KILN_CELL_PLACES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_CELL_PLACES_INL_H
#undef KILN_CELL_PLACES_INL_H
#else
#define KILN_CELL_PLACES_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "engine/pixel/cast_rays_in_cell.h"
#include "engine/shared/sample_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

// Offset of a voxel in a cell's voxels. `voxel` is counted from the voxel before the cell.
HWY_INLINE VI offsetOf(const VI (&voxel)[3]) {
  const DI di;
  constexpr int kPlane = CellInput::kPlane;
  const VI row = hn::Add(hn::Mul(voxel[2], hn::Set(di, kPlane)), hn::Mul(voxel[1], hn::Set(di, kPatchStride)));
  const VI first = hn::Set(di, (kPlane + kPatchStride + 1) * (kPatchMargin - 1));
  return hn::Add(hn::Add(row, voxel[0]), first);
}

// Mask of the lanes of a vector from the n-th of `count` elements on that hold elements.
HWY_INLINE M lanesBefore(std::size_t n, std::size_t count) {
  const DI di;
  return hn::RebindMask(D(), hn::Lt(hn::Iota(di, static_cast<int>(n)), hn::Set(di, static_cast<int>(count))));
}

// Code of a sample: bits 0 to 5 and 6 to 11 are the pixel's x and y from the corner of the cell's rectangle. Bits from
// 12 on are the slab; bit 30 marks a pair (one sample for two slabs).
class CellPlaces {
 public:
  static constexpr int kPixelBits = 6, kSlabBits = 2 * kPixelBits;
  static_assert(1 << kPixelBits == kSquareEdge);
  static constexpr std::int32_t kPixel = (1 << kSlabBits) - 1, kPair = 1 << 30;
  static_assert((kMostRaySlabs << kSlabBits) <= kPair);
  static constexpr float kFar = 1e30f;
  // Ends of pieces at the border of two slabs may be in either, as positions are rounded. unit: slabs.
  static constexpr float kRounded = 1e-3f;

  CellPlaces(const RaySampling& rays, const SampleLattice& lattice, const CellInput& in, const TilePixels& tile)
      : r_(rays),
        l_(lattice),
        in_(in),
        pieces_(in.at_end || !in.cuts.empty()),
        first_pixel_(tile.placeOf(in.rect.x0, in.rect.y0)),
        row_pixels_(tile.stride / 4),
        rgba_(tile.rgba) {}

  // Clips the rays' intervals [enter, leave] to the space between two faces across an axis (RaySampling::faceAt). A ray
  // parallel to the faces is inside if lo <= position < hi. unit: slabs from the middle slab.
  HWY_INLINE void cut(V place, V step, float lo, float hi, V& enter, V& leave) const {
    const D d;
    const V zero = hn::Zero(d), far = hn::Set(d, kFar), below = hn::Set(d, lo), above = hn::Set(d, hi);
    const M along = hn::Lt(hn::Abs(step), hn::Set(d, 1 / kFar));
    const V inverse = hn::Div(hn::Set(d, 1.0f), hn::IfThenElse(along, hn::Set(d, 1.0f), step));
    // Position that faces are counted from: the eye in perspective, otherwise the ray's place.
    const V from = l_.perspective ? zero : place, eye = l_.perspective ? hn::Set(d, r_.eye) : zero;
    const V at_lo = fused(hn::Sub(below, from), inverse, eye);
    const V at_hi = fused(hn::Sub(above, from), inverse, eye);
    const V inside = hn::IfThenElse(hn::And(hn::Le(below, from), hn::Lt(from, above)), far, hn::Neg(far));
    enter = hn::Max(enter, hn::IfThenElse(along, hn::Neg(inside), hn::Min(at_lo, at_hi)));
    leave = hn::Min(leave, hn::IfThenElse(along, inside, hn::Max(at_lo, at_hi)));
  }

  // Decoded samples: pixels from the image's centre, slabs from the middle slab, number of slabs that the sample
  // covers.
  struct Where {
    V x, y, t, slabs;
  };
  HWY_INLINE Where slabOf(VI code) const {
    const D d;
    const DI di;
    const VI mask = hn::Set(di, kSquareEdge - 1);
    const auto at = [&](VI whole, int first, float centre) {
      return hn::Add(hn::ConvertTo(d, hn::Add(whole, hn::Set(di, first))), hn::Set(d, centre));
    };
    const VI slab = hn::ShiftRight<kSlabBits>(hn::And(code, hn::Set(di, kPair - 1)));
    const M pair = hn::RebindMask(d, hn::Gt(code, hn::Set(di, kPair - 1)));
    return {at(hn::And(code, mask), in_.rect.x0, r_.centre_x),
            at(hn::And(hn::ShiftRight<kPixelBits>(code), mask), in_.rect.y0, r_.centre_y),
            hn::Add(at(slab, 0, -r_.middle), hn::IfThenElseZero(pair, hn::Set(d, 0.5f))),
            hn::Add(hn::Set(d, 1.0f), hn::IfThenElseZero(pair, hn::Set(d, 1.0f)))};
  }
  // True at the ends of the volume and at cuts, where samples may stand for other pieces of a ray than their slabs.
  bool inPieces() const { return pieces_; }
  // Decodes samples as the pieces of a ray that they stand for: the middle of the piece, and the slabs that the piece
  // covers; 0 slabs if the piece is cut off. kPieces: inPieces(), of which loops have two versions, as the search for a
  // piece is a call.
  template <bool kPieces>
  HWY_INLINE Where sampleOf(VI code) const {
    if constexpr (kPieces)
      return pieceOf(slabOf(code));
    else
      return slabOf(code);
  }
  HWY_INLINE Where sampleOf(VI code) const { return pieces_ ? sampleOf<true>(code) : sampleOf<false>(code); }
  // From now on a sample stands for its ray's whole chord in the volume (CellChords).
  void useChords(bool use) { chords_ = use; }
  // Order of operations as in CellRays, so that a sample lies exactly on its ray.
  HWY_INLINE static V linear(const RaySampling::Linear& l, int axis, const Where& w) {
    const D d;
    const V row = hn::Add(hn::Set(d, l.centre[axis]), hn::Mul(w.y, hn::Set(d, l.along_y[axis])));
    return fused(w.x, hn::Set(d, l.along_x[axis]), row);
  }
  // Index coordinate of a sample. unit: voxels from the anchor.
  HWY_INLINE V indexOf(int axis, const Where& w, float from) const {
    const D d;
    return hn::Add(hn::Sub(linear(r_.place, axis, w), hn::Set(d, from)), hn::Mul(w.t, linear(r_.step, axis, w)));
  }
  // Index coordinate of the position `at` on the ray of a sample. Equal bits in all cells, slabs and zones that meet
  // there. unit: `at` slabs from the middle slab; voxels from the anchor.
  HWY_INLINE V pointAt(int axis, const Where& w, V at) const {
    const D d;
    const V inner = hn::Add(linear(r_.place, axis, w), hn::Mul(at, linear(r_.step, axis, w)));
    const M begins = hn::Eq(at, hn::Set(d, -r_.middle - 0.5f));
    const M ends = hn::Eq(at, hn::Set(d, static_cast<float>(r_.end) - r_.middle - 0.5f));
    if (HWY_LIKELY(hn::AllFalse(d, hn::Or(begins, ends)))) return inner;
    return hn::IfThenElse(begins, linear(r_.at_begin, axis, w),
                          hn::IfThenElse(ends, linear(r_.at_end, axis, w), inner));
  }
  // Stores the voxel before each position `at` on the rays of a vector of samples, from the n-th on, and the position
  // between voxels. Both are computed from the volume's own voxels, so that they do not depend on the cell.
  HWY_INLINE void placeAt(std::size_t n, const Where& w, V at, CellSamples& samples) const {
    const D d;
    const DI di;
    VI voxel[3];
    for (int a = 0; a < 3; ++a) {
      const V place = pointAt(a, w, at), whole = hn::Floor(place);
      hn::Store(hn::Sub(place, whole), d, samples.fraction[a] + n);
      const VI from_cell = hn::Sub(hn::ConvertTo(di, whole), hn::Set(di, static_cast<std::int32_t>(in_.lo[a])));
      // Rounding may put a position just outside the cell.
      voxel[a] = hn::Min(hn::Max(from_cell, hn::Zero(di)), hn::Set(di, kPatchVoxels));
    }
    hn::Store(offsetOf(voxel), di, samples.offset + n);
  }
  HWY_INLINE Sight sightOf(const Where& w) const {
    const D d;
    const V one = hn::Set(d, 1.0f), per_pixel = hn::Set(d, 1 / l_.focal);
    const V u = hn::Mul(w.x, per_pixel), v = hn::Mul(w.y, per_pixel);
    if (!l_.perspective) return {u, v, one};
    return {u, v, hn::Sqrt(fused(u, u, fused(v, v, one)))};
  }
  // Position of a sample in view space. unit: world.
  HWY_INLINE Vector viewOf(const Where& w, const Sight& sight) const {
    const D d;
    const V slabs = hn::Add(w.t, hn::Set(d, r_.middle + 0.5f));
    const V z = fused(slabs, hn::Set(d, l_.thickness), hn::Set(d, l_.near));
    if (!l_.perspective) return {sight.u, sight.v, z};
    return {hn::Mul(sight.u, z), hn::Mul(sight.v, z), z};
  }
  // Clips the rays' intervals to the cell, and to the drawn part.
  HWY_INLINE void cutToCell(const Where& w, V& enter, V& leave) const {
    for (int a = 0; a < 3; ++a) {
      const V place = linear(r_.place, a, w), step = linear(r_.step, a, w);
      cut(place, step, r_.faceAt(a, in_.corner[a]), r_.faceAt(a, in_.end[a]), enter, leave);
      if (in_.part != nullptr)
        cut(place, step, r_.faceAt(a, in_.part->lo[a]), r_.faceAt(a, in_.part->hi[a]), enter, leave);
    }
  }
  // The first slab of the zone whose middle is at a position or behind, if any; else its end. unit: slabs from the
  // zone's begin; `at`: slabs from the middle slab.
  HWY_INLINE V slabFrom(V at) const {
    const D d;
    const V least = hn::Set(d, static_cast<float>(r_.first)), most = hn::Set(d, static_cast<float>(r_.end));
    return hn::Min(hn::Max(hn::Ceil(hn::Add(at, hn::Set(d, r_.middle))), least), most);
  }
  // The rays' spans inside the volume, empty if enter >= leave. unit: slabs from the middle slab.
  struct Span {
    V enter, leave;
  };
  HWY_INLINE Span inVolume(const Where& w) const {
    const D d;
    Span out{hn::Set(d, -kFar), hn::Set(d, kFar)};
    for (int a = 0; a < 3; ++a) cutToEnds(a, w, out.enter, out.leave);
    return out;
  }
  // Pixel of the picture and slab of a sample.
  struct Place {
    int x, y, slab;
  };
  HWY_INLINE Place placeOf(std::int32_t code) const {
    return {in_.rect.x0 + (code & (kSquareEdge - 1)), in_.rect.y0 + (code >> kPixelBits & (kSquareEdge - 1)),
            (code & (kPair - 1)) >> kSlabBits};
  }

  std::ptrdiff_t pixelPlace(std::int32_t pixel) const {
    return first_pixel_ + (pixel & (kSquareEdge - 1)) + (pixel >> kPixelBits) * row_pixels_;
  }
  float* pixelOf(std::int32_t pixel) const { return rgba_ + 4 * pixelPlace(pixel); }

 private:
  HWY_INLINE void cutToEnds(int axis, const Where& w, V& enter, V& leave) const {
    cut(linear(r_.place, axis, w), linear(r_.step, axis, w), r_.faceAt(axis, -0.5), r_.faceAt(axis, r_.volume_hi[axis]),
        enter, leave);
  }

  // The piece that stands in place of a sample's slabs. Not inline: few cells have pieces.
  HWY_NOINLINE Where pieceOf(const Where& w) const {
    const V half = hn::Set(D(), 0.5f), own = hn::Mul(half, w.slabs);
    const auto middleOf = [&](const Span& of) { return hn::Mul(half, hn::Add(of.enter, of.leave)); };
    Span piece{hn::Sub(w.t, own), hn::Add(w.t, own)};
    if (chords_)
      piece = inVolume(w);
    else if (in_.at_end)
      extendToEnds(w, own, piece);
    if (!in_.cuts.empty()) cutOff(w, chords_ ? middleOf(piece) : w.t, piece);
    return {w.x, w.y, middleOf(piece), hn::Sub(piece.leave, piece.enter)};
  }

  // The first and the last sample of a ray in the volume also stand for the remainder up to the volume's faces. The
  // tests for first and last equal those of CellRays. `own`: half the slabs of the sample.
  HWY_INLINE void extendToEnds(const Where& w, V own, Span& piece) const {
    const D d;
    // A sample reaches no other ends.
    V enter = hn::Set(d, -kFar), leave = hn::Set(d, kFar);
    for (int a = 0; a < 3; ++a) {
      if (in_.ends[static_cast<std::size_t>(a)]) cutToEnds(a, w, enter, leave);
    }
    const V half = hn::Set(d, 0.5f), one = hn::Set(d, 1.0f), middle = hn::Set(d, r_.middle);
    const V near = hn::Sub(hn::Add(w.t, half), own), far = hn::Sub(hn::Add(w.t, own), half);
    const auto slab = [&](V at) { return hn::Sub(hn::Ceil(hn::Add(at, middle)), middle); };
    const V begin = hn::Set(d, static_cast<float>(r_.first) - r_.middle);
    const V end = hn::Set(d, static_cast<float>(r_.end) - r_.middle - 1);
    const auto either = [](M m, M yes, M no) { return hn::Or(hn::And(m, yes), hn::AndNot(m, no)); };
    const M first = either(hn::Le(near, begin), hn::Gt(enter, hn::Set(d, r_.before)), hn::Le(near, slab(enter)));
    const M last =
        either(hn::Ge(far, end), hn::Le(leave, hn::Set(d, r_.after)), hn::Ge(hn::Add(far, one), slab(leave)));
    piece.enter = hn::IfThenElse(first, enter, piece.enter);
    piece.leave = hn::IfThenElse(last, leave, piece.leave);
  }

  // Cuts pieces at the faces of the clip region. Where points on the faces are samples, nothing may lie in front of
  // them: a sample whose middle is in front of a face is dropped. With several volumes, which have one sample in each
  // slab, a sample that a face cuts is dropped.
  // `middle`: middle of the uncut sample.
  HWY_INLINE void cutOff(const Where& w, V middle, Span& piece) const {
    const D d;
    const V zero = hn::Zero(d);
    V enter = hn::Set(d, -kFar), leave = hn::Set(d, kFar);
    for (const SampleFace& face : in_.cuts) {
      V at = hn::Set(d, face.offset), rate = zero;
      for (int a = 0; a < 3; ++a) {
        const V normal = hn::Set(d, face.normal[a]);
        at = fused(normal, linear(r_.place, a, w), at), rate = fused(normal, linear(r_.step, a, w), rate);
      }
      const M inwards = hn::Gt(rate, zero), outwards = hn::Lt(rate, zero);
      const V crossing = hn::Div(hn::Neg(at), hn::IfThenElse(hn::Or(inwards, outwards), rate, hn::Set(d, 1.0f)));
      enter = hn::IfThenElse(inwards, hn::Max(enter, crossing), enter);
      leave = hn::IfThenElse(outwards, hn::Min(leave, crossing), leave);
      const M outside = hn::AndNot(hn::Or(inwards, outwards), face.open ? hn::Le(at, zero) : hn::Lt(at, zero));
      leave = hn::IfThenElse(outside, hn::Set(d, -kFar), leave);
    }
    const V least = in_.sums != nullptr ? hn::Sub(piece.enter, hn::Set(d, kRounded)) : middle;
    const V near = hn::Min(hn::Max(piece.enter, enter), piece.leave);
    V far = hn::Max(hn::Min(piece.leave, leave), near);
    if (l_.points_on_faces) far = hn::IfThenElse(hn::Gt(enter, least), near, far);
    piece = {near, far};
  }

  const RaySampling& r_;
  const SampleLattice& l_;
  const CellInput& in_;
  const bool pieces_;                              // samples may stand for other pieces than their slabs
  const std::ptrdiff_t first_pixel_, row_pixels_;  // first pixel of the cell's rectangle in the tile; distance of rows
  float* const rgba_;
  bool chords_ = false;  // pieces are whole chords
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
