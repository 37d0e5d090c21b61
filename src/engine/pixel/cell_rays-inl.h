// Rays through a cell, and the places along them at which samples may be visible. Compiled once for each instruction
// set; hence no #pragma once.
#if defined(KILN_CELL_RAYS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_CELL_RAYS_INL_H
#undef KILN_CELL_RAYS_INL_H
#else
#define KILN_CELL_RAYS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>

#include "engine/pixel/cell_places-inl.h"
#include "engine/pixel/visible_spaces-inl.h"
#include "engine/shared/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

// Part of the rays that belongs to a cell:
// - kMiddles: the slabs whose middles are in the cell, each as one sample;
// - kPieces: the parts inside the cell of all slabs, for surfaces. Some slabs without a part may be found, too.
enum class RayParts { kMiddles, kPieces };

// Finds samples and calls cast(count) for the first `count` codes in CellSamples::code. `cast` may close pixels.
template <class Cast>
class CellRays {
 public:
  CellRays(const CellPlaces& places, const RaySampling& rays, const CellInput& in, const TilePixels& tile,
           CellSamples& samples, RayParts parts, Cast cast)
      : p_(places), r_(rays), in_(in), tile_(tile), s_(samples), pieces_(parts == RayParts::kPieces), cast_(cast) {}

  // `shown`: spaces in which samples may be visible; all spaces if empty.
  void run(const std::optional<Spaces>& shown) {
    if (!findBox(shown)) return;
    for (int y = in_.rect.y0; y < in_.rect.y1; ++y) {
      const glm::vec3 fy(static_cast<float>(y) + r_.centre_y);
      const glm::vec3 place = r_.place.centre + fy * r_.place.along_y, step = r_.step.centre + fy * r_.step.along_y;
      const int stride = r_.rayStride() * static_cast<int>(hn::Lanes(D()));
      for (int x = r_.firstRay(in_.rect.x0, y); x < in_.rect.x1; x += stride) findRays(x, y, place, step);
    }
    followRays();
    castFound();
  }

 private:
  static constexpr int kSlabBits = CellPlaces::kSlabBits;
  static constexpr float kFar = CellPlaces::kFar;
  // Number of slabs that rays advance before rays of closed pixels are dropped.
  static constexpr int kSlabsAtOnce = 6;
  // Parts of slabs are found with this margin, as positions are rounded. unit: slabs; voxels.
  static constexpr float kSlabMargin = 0.02f, kVoxelMargin = 0.01f;

  // Computes the box around the spaces in which samples may be visible; false if there are none.
  HWY_INLINE bool findBox(const std::optional<Spaces>& shown) {
    for (int a = 0; a < 3; ++a) lo_[a] = r_.faceAt(a, in_.corner[a]), hi_[a] = r_.faceAt(a, in_.end[a]);
    if (!shown) {
      shown_.fill(-1);
      return true;
    }
    static_assert(sizeof *shown == sizeof shown_);
    if (!pieces_)
      std::memcpy(shown_.data(), shown->data(), sizeof shown_);
    else if (r_.longestStep(in_.bounds) > 1 - 3 * kVoxelMargin)
      shown_.fill(-1);
    else
      std::memcpy(shown_.data(), spacesBefore(*shown).data(), sizeof shown_);
    SpaceBox box{};
    if (!boxOf(*shown, box)) return false;
    for (int a = 0; a < 3; ++a) {
      // Spaces begin half a voxel before the cell. The box is slightly larger than the spaces, as positions are
      // rounded.
      constexpr double kHalf = 0.51;
      if (box.first[a] > 0) lo_[a] = r_.faceAt(a, in_.corner[a] + box.first[a] - kHalf);
      const double end = in_.corner[a] + box.last[a] + kHalf;
      if (box.last[a] < kSpaces - 1 && end < in_.end[a]) hi_[a] = r_.faceAt(a, end);
    }
    return true;
  }

  // Keeps the rays of a vector of row y, from pixel x on, that pass through the box and whose pixels are open.
  HWY_INLINE void findRays(int x, int y, const glm::vec3& row_place, const glm::vec3& row_step) {
    const D d;
    const DI di;
    const int stride = r_.rayStride();
    const VI column = hn::Mul(hn::Iota(di, 0), hn::Set(di, stride));
    const V fx = hn::Add(hn::ConvertTo(d, hn::Add(column, hn::Set(di, x))), hn::Set(d, r_.centre_x));
    const auto along = [&](float row, float slope) { return fused(fx, hn::Set(d, slope), hn::Set(d, row)); };
    V enter = hn::Set(d, -kFar), leave = hn::Set(d, kFar);
    for (int a = 0; a < 3; ++a) {
      p_.cut(along(row_place[a], r_.place.along_x[a]), along(row_step[a], r_.step.along_x[a]), lo_[a], hi_[a], enter,
             leave);
    }
    const V middle = hn::Set(d, r_.middle);
    if (pieces_) {
      // The first slab contains the entry, the last slab the exit; a slab begins half a slab before its middle.
      enter = hn::Sub(enter, hn::Set(d, 0.5f + kSlabMargin));
      leave = hn::Add(leave, hn::Set(d, 0.5f + kSlabMargin + r_.overlap));
    }
    const V first = p_.slabFrom(enter), end = hn::Sub(p_.slabFrom(leave), middle);
    const int count = std::min(static_cast<int>(hn::Lanes(d)), (in_.rect.x1 - x + stride - 1) / stride);
    M through = hn::And(hn::Lt(hn::Sub(first, middle), end), lanesBefore(0, static_cast<std::size_t>(count)));
    if (hn::AllFalse(d, through)) return;
    const float* const pixels = tile_.rgba + 4 * tile_.placeOf(x, y);
    for (int i = 0; i < count; ++i) s_.alpha[i] = pixels[4 * stride * i + 3];
    through = hn::And(through, hn::Ne(hn::Load(d, s_.alpha), hn::Set(d, 1.0f)));
    const VI code =
        hn::Add(hn::Add(column, hn::Set(di, (x - in_.rect.x0) + ((y - in_.rect.y0) << CellPlaces::kPixelBits))),
                hn::ShiftLeft<kSlabBits>(hn::ConvertTo(di, first)));
    ray_count_ = keepRays(code, end, through, ray_count_);
    if (ray_count_ >= CellSamples::kMostRays) followRays();
  }

  // Advances the kept rays some slabs at a time, so that nothing behind a closed pixel is examined.
  HWY_NOINLINE void followRays() {
    while (ray_count_ > 0) {
      findPlaces();
      if (ray_count_ == 0) return;
      castFound();
      dropClosed();
    }
  }

  // Finds the places in the next slabs at which samples may be visible. Each lane follows a ray; ended rays are
  // dropped.
  HWY_INLINE void findPlaces() {
    const D d;
    const DI di;
    const V one = hn::Set(d, 1.0f);
    std::size_t left = 0;
    for (std::size_t n = 0; n < ray_count_; n += hn::Lanes(d)) {
      VI code = hn::Load(di, s_.ray_code + n);
      const V end = hn::IfThenElse(lanesBefore(n, ray_count_), hn::Load(d, s_.ray_end + n), hn::Set(d, -kFar));
      const CellPlaces::Where w = p_.slabOf(code);
      V place[3], step[3], t = w.t;
      for (int a = 0; a < 3; ++a) {
        place[a] = hn::Sub(CellPlaces::linear(r_.place, a, w), hn::Set(d, in_.lo[a]));
        step[a] = CellPlaces::linear(r_.step, a, w);
        // Parts of slabs are sought by the lowest of their spaces.
        if (pieces_) place[a] = hn::Sub(place[a], fused(hn::Set(d, 0.5f), hn::Abs(step[a]), hn::Set(d, kVoxelMargin)));
      }
      // A sample belongs to the part that contains its middle; for a pair, the middle of both slabs.
      const bool in_part = in_.part != nullptr && !pieces_;
      V enter = hn::Set(d, -kFar), leave = hn::Set(d, kFar);
      for (int a = 0; a < 3 && in_part; ++a)
        p_.cut(CellPlaces::linear(r_.place, a, w), step[a], r_.faceAt(a, in_.part->lo[a]),
               r_.faceAt(a, in_.part->hi[a]), enter, leave);
      M going = hn::Lt(t, end);
      for (int i = 0; i < kSlabsAtOnce && !hn::AllFalse(d, going); ++i) {
        V at = t, advance = one;
        VI taken = code;
        if (in_.in_pairs) {
          // Slabs 2n and 2n + 1 form a pair if both are in the cell.
          const VI odd = hn::And(code, hn::Set(di, 1 << kSlabBits));
          const M pair = hn::And(hn::RebindMask(d, hn::Eq(odd, hn::Zero(di))), hn::Lt(hn::Add(t, one), end));
          at = hn::Add(t, hn::IfThenElseZero(pair, hn::Set(d, 0.5f)));
          advance = hn::Add(one, hn::IfThenElseZero(pair, one));
          taken = hn::Add(code, hn::IfThenElseZero(hn::RebindMask(di, pair), hn::Set(di, CellPlaces::kPair)));
        }
        VI voxel[3];
        for (int a = 0; a < 3; ++a) {
          const VI whole = hn::ConvertTo(di, hn::Add(place[a], hn::Mul(at, step[a])));
          voxel[a] = hn::Min(hn::Max(whole, hn::Zero(di)), hn::Set(di, kSpaces - 1));
        }
        const VI word = hn::Add(hn::Add(voxel[2], voxel[2]), hn::ShiftRight<2>(voxel[1]));
        const VI place_in_word = hn::And(hn::Or(hn::ShiftLeft<3>(voxel[1]), voxel[0]), hn::Set(di, 31));
        const VI bit = hn::And(hn::Shr(shownOf(word), place_in_word), hn::Set(di, 1));
        auto may = hn::And(hn::RebindMask(di, going), hn::Ne(bit, hn::Zero(di)));
        if (pieces_ && r_.overlap > 0) {
          // The first slab begins in front of its own spaces.
          const VI slab = hn::ShiftRight<kSlabBits>(code);
          may = hn::Or(may, hn::And(hn::RebindMask(di, going), hn::Eq(slab, hn::Zero(di))));
        }
        if (in_part) may = hn::And(may, hn::RebindMask(di, hn::And(hn::Le(enter, at), hn::Lt(at, leave))));
        hn::StoreU(Packing(hn::RebindMask(d, may))(taken), di, s_.code + count_);
        count_ += hn::CountTrue(di, may);
        if (count_ >= CellSamples::kMost) castFound();
        t = hn::Add(t, advance);
        code = hn::Add(code, hn::ShiftLeft<kSlabBits>(hn::ConvertTo(di, advance)));
        going = hn::Lt(t, end);
      }
      left = keepRays(code, end, going, left);
    }
    ray_count_ = left;
  }

  void dropClosed() {
    const D d;
    std::size_t left = 0;
    for (std::size_t n = 0; n < ray_count_; n += hn::Lanes(d)) {
      const std::size_t count = std::min(ray_count_ - n, hn::Lanes(d));
      for (std::size_t i = 0; i < count; ++i) s_.alpha[i] = p_.pixelOf(s_.ray_code[n + i] & CellPlaces::kPixel)[3];
      const M open = hn::And(hn::Ne(hn::Load(d, s_.alpha), hn::Set(d, 1.0f)), lanesBefore(n, ray_count_));
      left = keepRays(hn::Load(DI(), s_.ray_code + n), hn::Load(d, s_.ray_end + n), open, left);
    }
    ray_count_ = left;
  }

  // Appends the rays of a vector in `kept` behind the first `count`. Returns the new count.
  HWY_INLINE std::size_t keepRays(VI code, V end, M kept, std::size_t count) {
    const D d;
    const DI di;
    const Packing packed(kept);
    hn::StoreU(packed(code), di, s_.ray_code + count);
    hn::StoreU(packed(end), d, s_.ray_end + count);
    return count + hn::CountTrue(d, kept);
  }

  HWY_INLINE VI shownOf(VI row) const { return lookUp(DI(), shown_.data(), row); }

  HWY_INLINE void castFound() {
    if (count_ > 0) cast_(count_);
    count_ = 0;
  }

  const CellPlaces& p_;
  const RaySampling& r_;
  const CellInput& in_;
  const TilePixels& tile_;
  CellSamples& s_;
  const bool pieces_;
  Cast cast_;
  float lo_[3], hi_[3];  // faces of the box of visible spaces (RaySampling::faceAt)
  std::size_t ray_count_ = 0, count_ = 0;
  alignas(64) std::array<std::int32_t, 16> shown_;  // Spaces
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
