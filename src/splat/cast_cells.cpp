#include "splat/cast_cells.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "splat/finish_sample.h"
#include "splat/slab_layer.h"
#include "splat/unit_load.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/cast_cells.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/classify-inl.h"
#include "splat/lanes-inl.h"
#include "splat/shown_spaces-inl.h"

#ifndef KILN_SPLAT_CAST_CELLS_ONCE
#define KILN_SPLAT_CAST_CELLS_ONCE
namespace kiln {
namespace {

// Edge of what is read for a cell, and from plane to plane of it. unit: voxels.
constexpr int kReadEdge = kUnitVoxels + 2 * kUnitMargin, kPlane = kReadEdge * kUnitSamples;

// A cell in a tile.
struct CellInput {
  const float* values = nullptr;  // loadUnit's
  glm::vec3 lo;                   // the voxel before its first. unit: voxels from the anchor
  glm::dvec3 corner, end;         // where it begins and ends, in index space
  PixelRect rect;                 // what of the tile it may be seen in
  bool at_end = false;            // of the volume
  bool in_pairs = false;          // whether two samples may be one, twice as long
  bool gaps = false;              // whether there may be NaN among its voxels
};

// Samples that go through a cell's steps together, at the most; and room for what vectors go beyond.
constexpr std::size_t kLanes = 16, kMostSamples = 512, kRoom = kMostSamples + 2 * kLanes;
// And rays, and slabs that these go on before those drop out that are closed.
constexpr std::size_t kMostRays = 512, kRayRoom = kMostRays + 2 * kLanes;
constexpr int kSlabsAtOnce = 6;
constexpr std::size_t kLit = 4 * kLanes;  // that are lit together

// What is known of them, for one cell after the other. Beyond the last one vectors read anything, and use none of it.
struct CellSamples {
  // Of each ray through the cell, the code of its first slab there, and where it ends.
  alignas(64) std::int32_t ray_code[kRayRoom];
  alignas(64) float ray_end[kRayRoom];
  // Of each sample that was found: its code, which voxels it is between, how far, and the values around it along x.
  alignas(64) std::int32_t code[kRoom], offset[kRoom];
  alignas(64) float fraction[3][kRoom], pair[2 * kRoom];
  // Of each that is kept: which of them it is, its place in the table, and so on.
  alignas(64) std::int32_t index[kRoom];
  alignas(64) float entry[kRoom], opacity[kRoom], weight[kRoom];
  // The same, where samples are finished one by one.
  alignas(64) float slope[3][kRoom], index_place[3][kRoom];
  // Of a vector of pixels, or of samples.
  alignas(64) float alpha[kLanes];
  alignas(64) std::int32_t lane_code[kLanes];
  // Of samples that are lit together.
  alignas(64) std::int32_t lit_code[kLit];
  alignas(64) float fraction_x[kLit], rows[4][4 * kLit];
  // Of each that closed its pixel.
  struct Closed {
    std::int32_t pixel;
    float alpha;
  };
  Closed closed[kRoom];
};

// What it did to them.
struct CellOutput {
  std::array<std::uint64_t, kSweepEdge> closed{};  // a bit a pixel of the rectangle
  std::uint64_t shown = 0, samples = 0;            // that show something, and that are seen
};

}  // namespace
}  // namespace kiln
#endif

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

using D2 = hn::CappedTag<float, 2>;
using D4 = hn::CappedTag<float, 4>;

// One cell, in steps that each go through many rays or samples, so that vectors are full and no sample waits for what
// was done to the one before: rays are found that go through what may show something; along them places where samples
// may; their values are interpolated and classified; those that do show something hide each other, one after the other;
// what is seen of them is lit. kGaps: whether voxels may be NaN.
template <bool kGaps>
class CellCaster {
 public:
  CellCaster(const RaySlabs& rays, const SlabFrame& frame, const CellInput& in, const TilePixels& tile, float opaque_at,
             CellSamples& samples, CellOutput& out)
      : r_(rays),
        frame_(frame),
        l_(frame.lattice()),
        in_(in),
        tile_(tile),
        opaque_at_(opaque_at),
        finishes_(frame.detailed()),
        derives_(finishes_ || tile.aovs.any()),
        s_(samples),
        out_(out) {}

  void run() {
    if (!findShown()) return;
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
  // A sample's code: its pixel, x + 2^6 y from the rectangle's corner; 2^12 times its slab; and whether it is two.
  static constexpr int kPixelBits = 6, kSlabBits = 2 * kPixelBits;
  static_assert(1 << kPixelBits == kSweepEdge);
  static constexpr std::int32_t kPixel = (1 << kSlabBits) - 1, kPair = 1 << 30;
  static_assert((kMostRaySlabs << kSlabBits) <= kPair);

  // Where samples may show something; false where none does. Sets the box around it.
  HWY_INLINE bool findShown() {
    for (int a = 0; a < 3; ++a) lo_[a] = r_.faceAt(a, in_.corner[a]), hi_[a] = r_.faceAt(a, in_.end[a]);
    // An interval reaches beyond what a sample interpolates.
    if (kGaps || l_.integral != nullptr) {
      shown_.fill(-1);
      return true;
    }
    const Spaces shown = shownSpaces(l_, in_.values);
    static_assert(sizeof shown == sizeof shown_);
    std::memcpy(shown_.data(), shown.data(), sizeof shown_);
    SpaceBox box{};
    if (!boxOf(shown, box)) return false;
    for (int a = 0; a < 3; ++a) {
      // Spaces begin half a voxel before the cell. A little more than them, as places are rounded.
      constexpr double kHalf = 0.51;
      if (box.first[a] > 0) lo_[a] = r_.faceAt(a, in_.corner[a] + box.first[a] - kHalf);
      const double end = in_.corner[a] + box.last[a] + kHalf;
      if (box.last[a] < kSpaces - 1 && end < in_.end[a]) hi_[a] = r_.faceAt(a, end);
    }
    return true;
  }

  // Whether there is, or may be, extinction between two places of the table.
  HWY_INLINE M visible(V lo, V hi) const {
    const D d;
    return hn::And(hn::Gt(hi, hn::Set(d, l_.visible_after)), hn::Lt(lo, hn::Set(d, l_.visible_before)));
  }

  // Which of a vector of row y's rays, from pixel x on, go through the box and are not closed.
  HWY_INLINE void findRays(int x, int y, const glm::vec3& row_place, const glm::vec3& row_step) {
    const D d;
    const DI di;
    const int stride = r_.rayStride();
    const VI column = hn::Mul(hn::Iota(di, 0), hn::Set(di, stride));
    const V fx = hn::Add(hn::ConvertTo(d, hn::Add(column, hn::Set(di, x))), hn::Set(d, r_.centre_x));
    const auto along = [&](float row, float slope) { return fused(fx, hn::Set(d, slope), hn::Set(d, row)); };
    V enter = hn::Set(d, -kFar), leave = hn::Set(d, kFar);
    for (int a = 0; a < 3; ++a) {
      cut(along(row_place[a], r_.place.along_x[a]), along(row_step[a], r_.step.along_x[a]), lo_[a], hi_[a], enter,
          leave);
    }
    const V middle = hn::Set(d, r_.middle);
    const V least = hn::Set(d, static_cast<float>(r_.first)), most = hn::Set(d, static_cast<float>(r_.end));
    const auto slab = [&](V at) { return hn::Min(hn::Max(hn::Ceil(hn::Add(at, middle)), least), most); };
    const V first = slab(enter), end = hn::Sub(slab(leave), middle);
    const int count = std::min(static_cast<int>(hn::Lanes(d)), (in_.rect.x1 - x + stride - 1) / stride);
    M through =
        hn::And(hn::Lt(hn::Sub(first, middle), end), hn::RebindMask(d, hn::Lt(hn::Iota(di, 0), hn::Set(di, count))));
    if (hn::AllFalse(d, through)) return;
    const float* const pixels = tile_.rgba + 4 * tile_.placeOf(x, y);
    for (int i = 0; i < count; ++i) s_.alpha[i] = pixels[4 * stride * i + 3];
    through = hn::And(through, hn::Ne(hn::Load(d, s_.alpha), hn::Set(d, 1.0f)));
    const VI code = hn::Add(hn::Add(column, hn::Set(di, (x - in_.rect.x0) + ((y - in_.rect.y0) << kPixelBits))),
                            hn::ShiftLeft<kSlabBits>(hn::ConvertTo(di, first)));
    ray_count_ = keepRays(code, end, through, ray_count_);
    if (ray_count_ >= kMostRays) followRays();
  }

  // Goes along these rays, some slabs at a time: what is behind those that close a pixel is not looked at.
  HWY_NOINLINE void followRays() {
    while (ray_count_ > 0) {
      findPlaces();
      if (ray_count_ == 0) return;
      castFound();
      dropClosed();
    }
  }

  // Where samples of the next slabs may show something. Each lane goes along its own ray; those that end there go.
  HWY_INLINE void findPlaces() {
    const D d;
    const DI di;
    const V one = hn::Set(d, 1.0f);
    std::size_t left = 0;
    for (std::size_t n = 0; n < ray_count_; n += hn::Lanes(d)) {
      VI code = hn::Load(di, s_.ray_code + n);
      const V end = hn::IfThenElse(raysFrom(n), hn::Load(d, s_.ray_end + n), hn::Set(d, -kFar));
      const Where w = whereIs(code);
      V place[3], step[3], t = w.t;
      for (int a = 0; a < 3; ++a) {
        place[a] = hn::Sub(linear(r_.place, a, w), hn::Set(d, in_.lo[a]));
        step[a] = linear(r_.step, a, w);
      }
      M going = hn::Lt(t, end);
      for (int i = 0; i < kSlabsAtOnce && !hn::AllFalse(d, going); ++i) {
        V at = t, advance = one;
        VI taken = code;
        if (in_.in_pairs) {
          // Slabs 2 n and 2 n + 1, where both are in the cell.
          const VI odd = hn::And(code, hn::Set(di, 1 << kSlabBits));
          const M pair = hn::And(hn::RebindMask(d, hn::Eq(odd, hn::Zero(di))), hn::Lt(hn::Add(t, one), end));
          at = hn::Add(t, hn::IfThenElseZero(pair, hn::Set(d, 0.5f)));
          advance = hn::Add(one, hn::IfThenElseZero(pair, one));
          taken = hn::Add(code, hn::IfThenElseZero(hn::RebindMask(di, pair), hn::Set(di, kPair)));
        }
        VI voxel[3];
        for (int a = 0; a < 3; ++a) {
          const VI whole = hn::ConvertTo(di, hn::Add(place[a], hn::Mul(at, step[a])));
          voxel[a] = hn::Min(hn::Max(whole, hn::Zero(di)), hn::Set(di, kSpaces - 1));
        }
        const VI word = hn::Add(hn::Add(voxel[2], voxel[2]), hn::ShiftRight<2>(voxel[1]));
        const VI place_in_word = hn::And(hn::Or(hn::ShiftLeft<3>(voxel[1]), voxel[0]), hn::Set(di, 31));
        const VI bit = hn::And(hn::Shr(shownOf(word), place_in_word), hn::Set(di, 1));
        const auto may = hn::And(hn::RebindMask(di, going), hn::Ne(bit, hn::Zero(di)));
        hn::StoreU(Packing(hn::RebindMask(d, may))(taken), di, s_.code + count_);
        count_ += hn::CountTrue(di, may);
        if (count_ >= kMostSamples) castFound();
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
      for (std::size_t i = 0; i < count; ++i) s_.alpha[i] = pixelOf(s_.ray_code[n + i] & kPixel)[3];
      const M open = hn::And(hn::Ne(hn::Load(d, s_.alpha), hn::Set(d, 1.0f)), raysFrom(n));
      left = keepRays(hn::Load(DI(), s_.ray_code + n), hn::Load(d, s_.ray_end + n), open, left);
    }
    ray_count_ = left;
  }

  // Of a vector, which are rays.
  HWY_INLINE M raysFrom(std::size_t n) const {
    const DI di;
    return hn::RebindMask(D(), hn::Lt(hn::Iota(di, static_cast<int>(n)), hn::Set(di, static_cast<int>(ray_count_))));
  }
  // Those of a vector behind the first `count` that are kept; how many there are then.
  HWY_INLINE std::size_t keepRays(VI code, V end, M kept, std::size_t count) {
    const D d;
    const DI di;
    const Packing packed(kept);
    hn::StoreU(packed(code), di, s_.ray_code + count);
    hn::StoreU(packed(end), d, s_.ray_end + count);
    return count + hn::CountTrue(d, kept);
  }

  HWY_INLINE VI shownOf(VI row) const { return lookUp(DI(), shown_.data(), row); }

  // Leaves what of rays is between two faces across an axis (RaySlabs::faceAt). A ray that never crosses them is on the
  // upper side of one that it runs in. unit: slabs from the middle one.
  HWY_INLINE void cut(V place, V step, float lo, float hi, V& enter, V& leave) const {
    const D d;
    const V zero = hn::Zero(d), far = hn::Set(d, kFar), below = hn::Set(d, lo), above = hn::Set(d, hi);
    const M along = hn::Lt(hn::Abs(step), hn::Set(d, 1 / kFar));
    const V inverse = hn::Div(hn::Set(d, 1.0f), hn::IfThenElse(along, hn::Set(d, 1.0f), step));
    // Places from where faces are told.
    const V from = l_.perspective ? zero : place, eye = l_.perspective ? hn::Set(d, r_.eye) : zero;
    const V at_lo = fused(hn::Sub(below, from), inverse, eye);
    const V at_hi = fused(hn::Sub(above, from), inverse, eye);
    const V inside = hn::IfThenElse(hn::And(hn::Le(below, from), hn::Lt(from, above)), far, hn::Neg(far));
    enter = hn::Max(enter, hn::IfThenElse(along, hn::Neg(inside), hn::Min(at_lo, at_hi)));
    leave = hn::Min(leave, hn::IfThenElse(along, inside, hn::Max(at_lo, at_hi)));
  }
  static constexpr float kFar = 1e30f;

  // Samples by their codes: pixels from the image's centre, slabs from the middle one, and of how many slabs they are.
  struct Where {
    V x, y, t, slabs;
  };
  HWY_INLINE Where whereIs(VI code) const {
    const D d;
    const DI di;
    const VI mask = hn::Set(di, kSweepEdge - 1);
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
  // In the order of findRays, so that a sample is where its ray goes.
  HWY_INLINE static V linear(const RaySlabs::Linear& l, int axis, const Where& w) {
    const D d;
    const V row = hn::Add(hn::Set(d, l.centre[axis]), hn::Mul(w.y, hn::Set(d, l.along_y[axis])));
    return fused(w.x, hn::Set(d, l.along_x[axis]), row);
  }
  // unit: voxels from the anchor.
  HWY_INLINE V indexOf(int axis, const Where& w, float from) const {
    const D d;
    return hn::Add(hn::Sub(linear(r_.place, axis, w), hn::Set(d, from)), hn::Mul(w.t, linear(r_.step, axis, w)));
  }
  HWY_INLINE Sight sightOf(const Where& w) const {
    const D d;
    const V one = hn::Set(d, 1.0f), per_pixel = hn::Set(d, 1 / l_.focal);
    const V u = hn::Mul(w.x, per_pixel), v = hn::Mul(w.y, per_pixel);
    if (!l_.perspective) return {u, v, one};
    return {u, v, hn::Sqrt(fused(u, u, fused(v, v, one)))};
  }
  // Of the n-th of `index` and those after it.
  HWY_INLINE VI codesAt(std::size_t n, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) s_.lane_code[i] = s_.code[s_.index[n + i]];
    return hn::Load(DI(), s_.lane_code);
  }

  HWY_NOINLINE void castFound() {
    placeAll();
    interpolateAll();
    classifyAll();
    attenuateAll();
    blendAll();
    lightAll();
    count_ = 0;
  }

  // Which voxels each is between, and how far.
  void placeAll() {
    const D d;
    const DI di;
    for (std::size_t n = 0; n < count_; n += hn::Lanes(d)) {
      const Where w = whereIs(hn::Load(di, s_.code + n));
      // From the second voxel that was read, half a voxel before the cell, on.
      VI voxel[3];
      for (int a = 0; a < 3; ++a) {
        const V at = indexOf(a, w, in_.lo[a]);
        // Rounding may put it beyond the cell.
        const V inside = hn::Min(hn::Max(at, hn::Set(d, 0.5f)), hn::Set(d, kUnitVoxels + 0.5f));
        voxel[a] = hn::ConvertTo(di, inside);
        hn::Store(hn::Sub(inside, hn::ConvertTo(d, voxel[a])), d, s_.fraction[a] + n);
      }
      const VI row = hn::Add(hn::Mul(voxel[2], hn::Set(di, kPlane)), hn::Mul(voxel[1], hn::Set(di, kUnitSamples)));
      const VI first = hn::Set(di, (kPlane + kUnitSamples + 1) * (kUnitMargin - 1));
      hn::Store(hn::Add(hn::Add(row, voxel[0]), first), di, s_.offset + n);
    }
  }

  // Of each, the values before and after it along x.
  void interpolateAll() {
    const D2 d;
    for (std::size_t n = 0; n < count_; ++n) {
      const float* const at = in_.values + s_.offset[n];
      const auto y = hn::Set(d, s_.fraction[1][n]), z = hn::Set(d, s_.fraction[2][n]);
      for (std::size_t i = 0; i < 2; i += hn::Lanes(d)) {
        const auto row = [&](int dy, int dz) { return hn::LoadU(d, at + dz * kPlane + dy * kUnitSamples + i); };
        const auto near = mix(d, row(0, 0), row(1, 0), y), far = mix(d, row(0, 1), row(1, 1), y);
        hn::Store(mix(d, near, far, z), d, s_.pair + 2 * n + i);
      }
    }
  }

  // Keeps those that show something, by their indices.
  void classifyAll() {
    const D d;
    const DI di;
    kept_ = 0;
    for (std::size_t n = 0; n < count_; n += hn::Lanes(d)) {
      V before, after;
      hn::LoadInterleaved2(d, s_.pair + 2 * n, before, after);
      const V value = mix(d, before, after, hn::Load(d, s_.fraction[0] + n)), entry = placeOf(d, l_, value);
      const VI index = hn::Iota(di, static_cast<int>(n));
      M shows = hn::RebindMask(d, hn::Lt(index, hn::Set(di, static_cast<int>(count_))));
      if (kGaps) shows = hn::And(shows, hn::Eq(value, value));
      V tau = hn::Zero(d);
      if (l_.integral != nullptr) {
        tau = meanExtinctionOf(n, value, entry, shows);
        shows = hn::And(shows, hn::Gt(tau, hn::Zero(d)));
      } else {
        shows = hn::And(shows, visible(entry, entry));
      }
      const Packing packed(shows);
      if (l_.integral != nullptr) hn::StoreU(packed(tau), d, s_.opacity + kept_);
      hn::StoreU(packed(index), di, s_.index + kept_);
      hn::StoreU(packed(entry), d, s_.entry + kept_);
      kept_ += hn::CountTrue(d, shows);
    }
  }

  // Of the n-th sample and those after it, at these places of the table.
  HWY_NOINLINE V meanExtinctionOf(std::size_t n, V value, V entry, M alive) {
    const D d;
    const D4 d4;
    const std::size_t count = std::min(count_ - n, hn::Lanes(d));
    // Rows through the sample along x, and those a voxel before and after it along y and z.
    enum { kHere, kBeforeY, kAfterY, kBeforeZ, kAfterZ, kRows };
    alignas(64) float rows[kRows][4 * kLanes] = {};
    for (std::size_t lane = 0; lane < count; ++lane) {
      const float* const at = in_.values + s_.offset[n + lane] - 1;
      const auto y = hn::Set(d4, s_.fraction[1][n + lane]), z = hn::Set(d4, s_.fraction[2][n + lane]);
      for (std::size_t i = 0; i < 4; i += hn::Lanes(d4)) {
        const auto row = [&](int dy, int dz) { return hn::LoadU(d4, at + dz * kPlane + dy * kUnitSamples + i); };
        const auto through = [&](int dy, int dz) {
          return mix(d4, mix(d4, row(dy, dz), row(dy, dz + 1), z), mix(d4, row(dy + 1, dz), row(dy + 1, dz + 1), z), y);
        };
        hn::Store(through(0, 0), d4, rows[kHere] + 4 * lane + i);
        hn::Store(through(-1, 0), d4, rows[kBeforeY] + 4 * lane + i);
        hn::Store(through(1, 0), d4, rows[kAfterY] + 4 * lane + i);
        hn::Store(through(0, -1), d4, rows[kBeforeZ] + 4 * lane + i);
        hn::Store(through(0, 1), d4, rows[kAfterZ] + 4 * lane + i);
      }
    }
    const V x = hn::Load(d, s_.fraction[0] + n);
    const auto of = [&](int row, std::size_t first) {
      V v[4];
      hn::LoadInterleaved4(d, rows[row], v[0], v[1], v[2], v[3]);
      return mix(d, v[first], v[first + 1], x);
    };
    const V before[3] = {of(kHere, 0), of(kBeforeY, 1), of(kBeforeZ, 1)};
    const V after[3] = {of(kHere, 2), of(kAfterY, 1), of(kAfterZ, 1)};
    const V place = hn::IfThenElseZero(alive, entry);
    const V at_point = extinctionAt(d, l_, place);
    return meanExtinction(d, l_, intervalOf(d, value, before, after), place, alive, at_point);
  }

  // Their opacities.
  void attenuateAll() {
    const D d;
    const DI di;
    for (std::size_t n = 0; n < kept_; ++n)
      std::memcpy(s_.pair + 2 * n, l_.extinctions + static_cast<std::int32_t>(s_.entry[n]), 2 * sizeof(float));
    const bool asks = l_.perspective || in_.at_end || in_.in_pairs || derives_;
    for (std::size_t n = 0; n < kept_; n += hn::Lanes(d)) {
      const V entry = hn::Load(d, s_.entry + n);
      V here, next;
      hn::LoadInterleaved2(d, s_.pair + 2 * n, here, next);
      V tau = between(here, next, hn::Sub(entry, hn::ConvertTo(d, hn::ConvertTo(di, entry))));
      if (l_.integral != nullptr) tau = hn::Load(d, s_.opacity + n);
      V length = hn::Set(d, l_.thickness);
      if (asks) {
        const std::size_t count = std::min(kept_ - n, hn::Lanes(d));
        const Where w = whereIs(codesAt(n, count));
        length = hn::Mul(hn::Mul(length, sightOf(w).oblique), in_.at_end ? partOf(w) : w.slabs);
        if (derives_) tau = finishTau(n, count, w, tau);
      }
      hn::Store(opacityOf(d, hn::Mul(tau, length)), d, s_.opacity + n);
    }
  }

  // What of its slabs lies in the volume. The first and the last sample stand for what is beside them, too: those that
  // findRays, whose words these are, has as the first and the last.
  HWY_INLINE V partOf(const Where& w) const {
    const D d;
    V enter = hn::Set(d, -kFar), leave = hn::Set(d, kFar);
    for (int a = 0; a < 3; ++a)
      cut(linear(r_.place, a, w), linear(r_.step, a, w), r_.faceAt(a, -0.5), r_.faceAt(a, r_.volume_hi[a]), enter,
          leave);
    const V half = hn::Set(d, 0.5f), one = hn::Set(d, 1.0f), middle = hn::Set(d, r_.middle);
    const V own = hn::Mul(w.slabs, half), near = hn::Sub(hn::Add(w.t, half), own),
            far = hn::Sub(hn::Add(w.t, own), half);
    const auto slab = [&](V at) { return hn::Sub(hn::Ceil(hn::Add(at, middle)), middle); };
    const V begin = hn::Set(d, static_cast<float>(r_.first) - r_.middle);
    const V end = hn::Set(d, static_cast<float>(r_.end) - r_.middle - 1);
    const auto either = [](M m, M yes, M no) { return hn::Or(hn::And(m, yes), hn::AndNot(m, no)); };
    const M first = either(hn::Le(near, begin), hn::Gt(enter, hn::Set(d, r_.before)), hn::Le(near, slab(enter)));
    const M last =
        either(hn::Ge(far, end), hn::Le(leave, hn::Set(d, r_.after)), hn::Ge(hn::Add(far, one), slab(leave)));
    return hn::Add(hn::IfThenElse(first, hn::Sub(w.t, enter), own), hn::IfThenElse(last, hn::Sub(leave, w.t), own));
  }

  // What kernels do not know: sites are kept for colours, and extinctions are what is left of them.
  HWY_NOINLINE V finishTau(std::size_t n, std::size_t count, const Where& w, V tau) {
    const D d;
    findSlopes(n, count);
    const Vector slope = slopesAt(0);
    hn::StoreU(slope.x, d, s_.slope[0] + n);
    hn::StoreU(slope.y, d, s_.slope[1] + n);
    hn::StoreU(slope.z, d, s_.slope[2] + n);
    for (int a = 0; a < 3; ++a) hn::StoreU(indexOf(a, w, 0), d, s_.index_place[a] + n);
    if (!finishes_) return tau;
    alignas(64) float taus[kLanes], steps[3][kLanes], slabs[kLanes];
    hn::Store(tau, d, taus);
    hn::Store(w.slabs, d, slabs);
    for (int a = 0; a < 3; ++a) hn::Store(linear(r_.step, a, w), d, steps[a]);
    for (std::size_t i = 0; i < count; ++i) {
      const SampleSite site = siteOf(n + i);
      // Along an axis that its ray does not follow it has next to no length, but one.
      glm::dvec3 edges(1e-6);
      for (int a = 0; a < 3; ++a) edges[a] += static_cast<double>(std::abs(steps[a][i]) * slabs[i]);
      const auto share = static_cast<float>(frame_.look().clip->shareOf(site.index, edges));
      taus[i] = share * finishedExtinction(frame_.look(), taus[i], site);
    }
    return hn::Load(d, taus);
  }

  SampleSite siteOf(std::size_t n) const {
    SampleSite out;
    for (int a = 0; a < 3; ++a)
      out.index[a] = static_cast<double>(r_.anchor[a]) + static_cast<double>(s_.index_place[a][n]);
    out.gradient = {s_.slope[0][n], s_.slope[1][n], s_.slope[2][n]};
    if (!std::isfinite(out.gradient.x + out.gradient.y + out.gradient.z)) out.gradient = glm::vec3(0);
    out.view = frame_.projector().viewOfIndex(out.index);
    return out;
  }

  // What of each is seen: of a pixel's samples the nearest comes first. What is seen is kept, and what it is multiplied
  // by. A pixel that reaches the threshold is closed; its colours are divided by its alpha when they are all there.
  void blendAll() {
    std::size_t seen = 0;
    closed_count_ = 0;
    out_.shown += kept_;
    for (std::size_t n = 0; n < kept_; ++n) {
      const std::int32_t pixel = s_.code[s_.index[n]] & kPixel;
      float& alpha = pixelOf(pixel)[3];
      // Nothing where the pixel is closed. No branches, as nobody can tell which samples close a pixel, or are behind
      // it.
      const float before = alpha, weight = (1 - before) * s_.opacity[n];
      alpha = before + weight;
      const bool closes = (alpha >= opaque_at_) & (before != 1.0f);
      s_.index[seen] = s_.index[n], s_.entry[seen] = s_.entry[n], s_.weight[seen] = weight;
      if (derives_) {
        for (int a = 0; a < 3; ++a) s_.slope[a][seen] = s_.slope[a][n], s_.index_place[a][seen] = s_.index_place[a][n];
        if (tile_.aovs.any() && weight > 0) addAovs(seen, pixel, before, weight, s_.opacity[n], closes);
      }
      seen += weight > 0 ? 1 : 0;
      if (!closes) continue;
      s_.closed[closed_count_++] = {pixel, alpha};
      alpha = 1.0f;
    }
    kept_ = seen;
    out_.samples += seen;
  }

  HWY_NOINLINE void addAovs(std::size_t n, std::int32_t pixel, float before, float weight, float opacity, bool closes) {
    const SampleSite site = siteOf(n);
    const SlabZone& zone = frame_.zone();
    SlabLayer layer;
    layer.before = before;
    layer.added = weight;
    layer.closes = closes;
    layer.opacity = opacity;
    layer.filled = 1;
    layer.turn = 0;
    layer.place = 0;
    layer.middle = site.view.z;
    layer.thickness = (s_.code[s_.index[n]] >= kPair ? 2 : 1) * zone.thickness;
    const glm::vec3 normal = finishedNormal(frame_.look(), site);
    for (int a = 0; a < 3; ++a) layer.normal[a] = weight * normal[a];
    addLayer(layer, tile_.aovs, pixelPlace(pixel));
  }

  // Adds the light of what is seen, some vectors at a time: what is done to single samples is on its way long before a
  // vector of them is asked for.
  void lightAll() {
    for (std::size_t n = 0; n < kept_; n += kLit) light(n, std::min(kept_ - n, kLit));
    for (std::size_t i = 0; i < closed_count_; ++i) {
      const auto [place, alpha] = s_.closed[i];
      const float by[4] = {alpha, alpha, alpha, 1};
      float* const pixel = pixelOf(place);
      for (std::size_t c = 0; c < 4; c += hn::Lanes(D4()))
        hn::StoreU(hn::Div(hn::LoadU(D4(), pixel + c), hn::LoadU(D4(), by + c)), D4(), pixel + c);
      out_.closed[static_cast<std::size_t>(place >> kPixelBits)] |= std::uint64_t{1} << (place & (kSweepEdge - 1));
    }
  }

  HWY_INLINE void light(std::size_t n, std::size_t count) {
    const D d;
    const D4 d4;
    for (std::size_t i = 0; i < count; ++i) {
      s_.lit_code[i] = s_.code[s_.index[n + i]];
      const float entry = s_.entry[n + i];
      const auto whole = static_cast<std::int32_t>(entry);
      const float* const at = l_.table + 4 * static_cast<std::ptrdiff_t>(whole);
      const auto t = hn::Set(d4, entry - static_cast<float>(whole));
      for (std::size_t c = 0; c < 4; c += hn::Lanes(d4)) {
        const auto here = hn::LoadU(d4, at + c);
        hn::Store(between(here, hn::LoadU(d4, at + 4 + c), t), d4, s_.rows[0] + 4 * i + c);
      }
    }
    if (finishes_) finishColors(n, count);
    if (l_.light.phong) findSlopes(n, count);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
      V red, green, blue, unused;
      hn::LoadInterleaved4(d, s_.rows[0] + 4 * i, red, green, blue, unused);
      if (l_.light.phong) {
        V matte = hn::Set(d, 1.0f), gloss = hn::Zero(d);
        const Sight sight = sightOf(whereIs(hn::Load(DI(), s_.lit_code + i)));
        lightOn(d, l_.light, l_.perspective, slopesAt(i), sight, matte, gloss);
        const auto lit = [&](V color) { return fused(color, matte, gloss); };
        red = lit(red), green = lit(green), blue = lit(blue);
      }
      const V weight = hn::LoadU(d, s_.weight + n + i);
      hn::StoreInterleaved4(hn::Mul(weight, red), hn::Mul(weight, green), hn::Mul(weight, blue), hn::Zero(d), d,
                            s_.rows[0] + 4 * i);
    }
    for (std::size_t i = 0; i < count; ++i) {
      float* const to = pixelOf(s_.lit_code[i] & kPixel);
      for (std::size_t c = 0; c < 4; c += hn::Lanes(d4))
        hn::StoreU(hn::Add(hn::LoadU(d4, to + c), hn::Load(d4, s_.rows[0] + 4 * i + c)), d4, to + c);
    }
  }

  HWY_NOINLINE void finishColors(std::size_t n, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      float* const rgba = s_.rows[0] + 4 * i;
      const Color color = finishedColor(frame_.look(), {rgba[0], rgba[1], rgba[2], rgba[3]}, siteOf(n + i));
      rgba[0] = color.r, rgba[1] = color.g, rgba[2] = color.b;
    }
  }

  // Central differences of the n-th of `index` and those after it, up to kLit: interpolated along y and z, of four
  // voxels along x at a time.
  HWY_INLINE void findSlopes(std::size_t n, std::size_t count) {
    const D4 d4;
    for (std::size_t lane = 0; lane < count; ++lane) {
      const auto index = static_cast<std::size_t>(s_.index[n + lane]);
      const float* const at = in_.values + s_.offset[index] - 1;
      s_.fraction_x[lane] = s_.fraction[0][index];
      const auto y = hn::Set(d4, s_.fraction[1][index]), z = hn::Set(d4, s_.fraction[2][index]);
      for (std::size_t i = 0; i < 4; i += hn::Lanes(d4)) {
        const auto row = [&](int dy, int dz) { return hn::LoadU(d4, at + dz * kPlane + dy * kUnitSamples + i); };
        const auto of_row = [&](int dy) { return mix(d4, row(dy, 0), row(dy, 1), z); };
        const auto along_z = [&](int dy) {
          return mix(d4, hn::Sub(row(dy, 1), row(dy, -1)), hn::Sub(row(dy, 2), row(dy, 0)), z);
        };
        const auto before = of_row(-1), here = of_row(0), next = of_row(1), after = of_row(2);
        hn::Store(mix(d4, here, next, y), d4, s_.rows[1] + 4 * lane + i);
        hn::Store(mix(d4, hn::Sub(next, before), hn::Sub(after, here), y), d4, s_.rows[2] + 4 * lane + i);
        hn::Store(mix(d4, along_z(0), along_z(1), y), d4, s_.rows[3] + 4 * lane + i);
      }
    }
  }

  // Of the i-th of these and those after it, interpolated along x, too. unit: value per voxel.
  HWY_INLINE Vector slopesAt(std::size_t i) const {
    const D d;
    const V x = hn::Load(d, s_.fraction_x + i), half = hn::Set(d, 0.5f);
    V before, here, next, after, y_here, y_next, z_here, z_next, unused, other;
    hn::LoadInterleaved4(d, s_.rows[1] + 4 * i, before, here, next, after);
    hn::LoadInterleaved4(d, s_.rows[2] + 4 * i, unused, y_here, y_next, other);
    hn::LoadInterleaved4(d, s_.rows[3] + 4 * i, unused, z_here, z_next, other);
    return {hn::Mul(half, mix(d, hn::Sub(next, before), hn::Sub(after, here), x)),
            hn::Mul(half, mix(d, y_here, y_next, x)), hn::Mul(half, mix(d, z_here, z_next, x))};
  }

  // a + t (b - a), the end itself where t is 0: a voxel without weight may be NaN.
  template <class Tag, class Vec>
  static HWY_INLINE Vec mix(Tag d, Vec a, Vec b, Vec t) {
    const Vec out = between(a, b, t);
    if constexpr (kGaps) return hn::IfThenElse(hn::Eq(t, hn::Zero(d)), a, out);
    return out;
  }

  std::ptrdiff_t pixelPlace(std::int32_t pixel) const {
    return tile_.placeOf(in_.rect.x0 + (pixel & (kSweepEdge - 1)), in_.rect.y0 + (pixel >> kPixelBits));
  }
  float* pixelOf(std::int32_t pixel) const { return tile_.rgba + 4 * pixelPlace(pixel); }

  const RaySlabs& r_;
  const SlabFrame& frame_;
  const UnitLattice& l_;
  const CellInput& in_;
  const TilePixels& tile_;
  const float opaque_at_;
  const bool finishes_;  // whether samples are lit, cut and made less opaque one by one
  const bool derives_;   // whether that, or their places and gradients are asked for
  CellSamples& s_;
  CellOutput& out_;
  float lo_[3], hi_[3];  // faces around what may show something, as RaySlabs::faceAt has them
  std::size_t ray_count_ = 0, count_ = 0, kept_ = 0, closed_count_ = 0;
  alignas(64) std::array<std::int32_t, 16> shown_;  // spacesBeside
};

void castCell(const RaySlabs& rays, const SlabFrame& frame, const CellInput& in, const TilePixels& tile,
              float opaque_at, CellSamples& samples, CellOutput& out) {
  if (in.gaps)
    CellCaster<true>(rays, frame, in, tile, opaque_at, samples, out).run();
  else
    CellCaster<false>(rays, frame, in, tile, opaque_at, samples, out).run();
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {

HWY_EXPORT(castCell);

namespace {

// Rows of a brick lie far from each other: a cell's are asked for before they are needed.
void fetch(const BrickBlock& block, const VoxelBox& cell) {
  const VoxelBox box = intersection(dilated(cell, kUnitMargin), block.extent);
  const auto bytes = static_cast<std::int64_t>(sizeOf(block.type));
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      const std::byte* const row = block.data<std::byte>() + bytes * block.offsetOf({box.lo.x, y, z});
      hwy::Prefetch(row);
      hwy::Prefetch(row + bytes * (box.hi.x - box.lo.x) - 1);
    }
  }
}

struct SeenCell {
  const SlabCell* cell = nullptr;
  PixelRect rect;
};

class Casting {
 public:
  Casting(const RaySlabs& rays, const SlabFrame& frame, const BrickBlock& block, const TilePixels& tile,
          Visibility& visibility, float opaque_at, SplatCounts& counts)
      : rays_(rays),
        frame_(frame),
        block_(block),
        tile_(tile),
        visibility_(visibility),
        opaque_at_(opaque_at),
        counts_(counts) {}

  // One cell is fetched while the one before it is cast, which may hide it.
  void run(std::span<const SlabCell> cells) {
    SeenCell due;
    for (const SlabCell& cell : cells) {
      const SeenCell next{&cell, intersection(cell.bounds.rect, tile_.rect)};
      if (next.rect.empty() || hidden(next.rect)) continue;
      fetch(block_, cell.box);
      cast(due);
      due = next;
    }
    cast(due);
  }

 private:
  bool hidden(const PixelRect& rect) {
    const bool out = visibility_.hidden(rect);
    ++counts_.nodes_tested;
    counts_.nodes_hidden += out ? 1 : 0;
    return out;
  }

  void cast(const SeenCell& seen) {
    if (seen.cell == nullptr || visibility_.hidden(seen.rect)) return;
    const VoxelBox& box = seen.cell->box;
    alignas(64) float values[kReadEdge * kPlane + kUnitSamples];
    CellInput in;
    const SampledRange range = loadUnit(block_, frame_.lattice(), frame_.table().offset(), box.lo, values).whole;
    in.values = values;
    for (int a = 0; a < 3; ++a) {
      const bool last = box.hi[a] == frame_.dims()[a];
      in.lo[a] = static_cast<float>(box.lo[a] - rays_.anchor[a]) - 1.0f;
      in.corner[a] = static_cast<double>(box.lo[a]) - 0.5;
      in.end[a] = last ? rays_.volume_hi[a] : static_cast<double>(box.hi[a]) - 0.5;
      in.at_end = in.at_end || last || box.lo[a] == 0;
    }
    in.rect = seen.rect;
    in.gaps = range.gaps;
    in.in_pairs = frame_.inPairs(range);
    CellOutput out;
    HWY_DYNAMIC_DISPATCH(castCell)(rays_, frame_, in, tile_, opaque_at_, samples_, out);
    counts_.visited += out.shown, counts_.splats += out.samples;
    counts_.changed = counts_.changed || out.samples > 0;
    for (int y = 0; y < in.rect.height(); ++y) {
      for (std::uint64_t rest = out.closed[static_cast<std::size_t>(y)]; rest != 0; rest &= rest - 1)
        close(in.rect.x0 + std::countr_zero(rest), in.rect.y0 + y);
    }
  }

  // In quincunx, of two pixels beside each other one has a ray, and hides for both.
  void close(int x, int y) {
    visibility_.close(x, y);
    if (rays_.quincunx) visibility_.close(x ^ 1, y);
  }

  const RaySlabs& rays_;
  const SlabFrame& frame_;
  const BrickBlock& block_;
  const TilePixels& tile_;
  Visibility& visibility_;
  const float opaque_at_;
  SplatCounts& counts_;
  CellSamples samples_;
};

}  // namespace

void castCells(const RaySlabs& rays, const SlabFrame& frame, const BrickBlock& block, std::span<const SlabCell> cells,
               const TilePixels& tile, Visibility& visibility, float opaque_at, SplatCounts& counts) {
  Casting(rays, frame, block, tile, visibility, opaque_at, counts).run(cells);
}

}  // namespace kiln
#endif
