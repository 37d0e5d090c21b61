#include "splat/lay_sheet.h"

#include <algorithm>

#include "splat/sheet.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/lay_sheet.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

class BlockLayer {
  using D = hn::CappedTag<float, kBlockEdge>;
  using DI = hn::RebindToSigned<D>;
  using V = hn::Vec<D>;
  using VI = hn::Vec<DI>;

 public:
  BlockLayer(const SheetBlock& block, LaidPixels* pixels) : b_(block), pixels_(pixels) {}

  LaidBlock run() {
    const auto lanes = static_cast<int>(hn::Lanes(D()));
    for (int y = 0; y < b_.height; ++y) {
      for (int x = 0; x < b_.width; x += lanes) {
        float* const pixels = b_.pixels + y * b_.stride + 4 * x;
        CoveredPixel* const covered = b_.covered + y * (b_.stride / 4) + x;
        if (x + lanes <= b_.width) {
          lay(x, y, pixels, covered);
          continue;
        }
        // Fewer than a vector.
        alignas(64) float some[4 * kBlockEdge] = {};
        const auto count = static_cast<std::size_t>(4 * (b_.width - x));
        std::copy_n(pixels, count, some);
        CoveredPixel some_covered[kBlockEdge] = {};
        std::copy_n(covered, count / 4, some_covered);
        lay(x, y, some, some_covered);
        std::copy_n(some, count, pixels);
        std::copy_n(some_covered, count / 4, covered);
      }
    }
    return out_;
  }

 private:
  // As many pixels of row y as a vector has lanes, from x on.
  void lay(int x, int y, float* pixels, CoveredPixel* covered) {
    const DI di;
    const auto row = static_cast<std::size_t>(y);
    std::int32_t* const filled = b_.filled + y * b_.columns + x;
    const VI fill = hn::LoadU(di, filled);
    if (hn::AllFalse(di, hn::Ne(fill, hn::Zero(di)))) return;
    hn::StoreU(hn::Zero(di), di, filled);
    std::int32_t* const sums = b_.sums + 4 * (y * b_.columns + x);
    const unsigned takes = static_cast<unsigned>(b_.takes[row]) >> x;
    const VI bit = hn::Shl(hn::Set(di, 1), hn::Iota(di, 0));
    const auto taking = hn::Ne(hn::And(hn::Set(di, static_cast<std::int32_t>(takes)), bit), hn::Zero(di));
    if (!hn::AllFalse(di, taking)) add(x, row, sums, fill, taking, pixels, covered);
    for (std::size_t i = 0; i < 4; ++i) hn::StoreU(hn::Zero(di), di, sums + i * hn::Lanes(di));
  }

  template <class Mask>
  HWY_INLINE void add(int x, std::size_t row, const std::int32_t* sums, VI fill, Mask taking, float* pixels,
                      CoveredPixel* covered) {
    const D d;
    const DI di;
    VI light[4];
    hn::LoadInterleaved4(di, sums, light[0], light[1], light[2], light[3]);
    const auto changed = hn::RebindMask(d, hn::And(taking, hn::Ne(light[3], hn::Zero(di))));
    V r, g, b, a;
    hn::LoadInterleaved4(d, pixels, r, g, b, a);
    const V full = hn::ConvertTo(d, fill);
    const V part = partOf(hn::Div(full, hn::Set(d, Sheet::kOne)), hn::Div(hn::ConvertTo(d, light[3]), full));
    const V share = hn::Div(seen(part, a, changed, covered), full);
    const auto sum = [&](V before, VI of, V by) {
      return hn::IfThenElse(changed, hn::Add(before, hn::Mul(by, hn::ConvertTo(d, of))), before);
    };
    const V unit = hn::Set(d, b_.color_unit), colored = hn::Mul(share, unit);
    const V alpha = sum(a, light[3], share);
    hn::StoreInterleaved4(sum(r, light[0], colored), sum(g, light[1], colored), sum(b, light[2], colored), alpha, d,
                          pixels);
    const auto opaque = hn::And(changed, hn::Ge(alpha, hn::Set(d, b_.opaque_at)));
    out_.changed[row] |= static_cast<std::uint8_t>(bitsOf(D(), changed) << x);
    out_.opaque[row] |= static_cast<std::uint8_t>(bitsOf(D(), opaque) << x);
    if (pixels_ != nullptr) {
      const std::size_t place = row * kBlockEdge + static_cast<std::size_t>(x);
      hn::StoreInterleaved4(a, share, hn::ConvertTo(d, light[3]), full, d, &pixels_->pixels[place].before);
      const auto whole = [&](VI of) { return hn::Mul(hn::Div(hn::ConvertTo(d, of), full), unit); };
      hn::StoreInterleaved4(whole(light[0]), whole(light[1]), whole(light[2]), part, d, pixels_->slabs[place].rgb);
    }
  }

  // What of a pixel's area a slab covers whose samples fill `filled` of it with `opacity`: a steep step, for a
  // footprint is wider than a pixel. In a medium that is thin it is flat where all is filled: samples fill a pixel a
  // little more or less than that everywhere, and nothing in front or behind makes up for what is less.
  V partOf(V filled, V opacity) const {
    const D d;
    const V one = hn::Set(d, 1.0f);
    const V clear = hn::Sub(one, opacity);
    const V two_slabs = hn::Mul(clear, clear);
    const V solid = hn::Sub(one, hn::Mul(two_slabs, two_slabs));  // solidOf
    const V erosion = hn::Mul(hn::Set(d, b_.erosion), solid);
    const V empty = hn::Sub(one, hn::Min(filled, one));
    const V f = hn::Max(hn::Sub(one, hn::Mul(empty, hn::Add(one, erosion))), hn::Zero(d));
    const V steep = hn::Sub(hn::Set(d, 3.0f), hn::Add(f, f));
    const V six = hn::Sub(hn::Mul(hn::Set(d, 6.0f), f), hn::Set(d, 15.0f));
    const V flat = hn::Mul(f, hn::Add(hn::Mul(f, six), hn::Set(d, 10.0f)));
    return hn::Mul(hn::Mul(f, f), hn::Add(flat, hn::Mul(solid, hn::Sub(steep, flat))));
  }

  // Of a pixel's area, what sees a slab that covers `part` of it. What slabs in front cover has the pixel's `alpha`;
  // what they do not cover is clear.
  template <class Mask>
  static HWY_INLINE V seen(V part, V alpha, Mask changed, CoveredPixel* covered) {
    const D d;
    const DI di;
    const hn::Rebind<CoveredPixel, D> dc;
    const V all = hn::Set(d, 255.0f);
    const V before = hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(dc, covered)));
    const V after = hn::IfThenElse(changed, hn::Max(before, hn::Ceil(hn::Mul(part, all))), before);
    hn::StoreU(hn::DemoteTo(dc, hn::ConvertTo(di, after)), dc, covered);
    // Where nothing is covered, alpha is nothing, too.
    const V in_front = hn::Mul(before, hn::Set(d, 1.0f / 255));
    const V density = hn::Min(hn::Div(alpha, hn::Max(in_front, hn::Set(d, 1.0f / 255))), hn::Set(d, 1.0f));
    return hn::Sub(part, hn::Mul(hn::Min(part, in_front), density));
  }

  const SheetBlock& b_;
  LaidPixels* const pixels_;
  LaidBlock out_;
};

LaidBlock laySheetOn(const SheetBlock& block, LaidPixels* pixels) { return BlockLayer(block, pixels).run(); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {

HWY_EXPORT(laySheetOn);

LaidBlock laySheet(const SheetBlock& block, LaidPixels* pixels) {
  return HWY_DYNAMIC_DISPATCH(laySheetOn)(block, pixels);
}

}  // namespace kiln
#endif
