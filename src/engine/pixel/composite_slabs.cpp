#include "engine/pixel/composite_slabs.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "engine/pixel/slab_layer.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/pixel/composite_slabs.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/shared/lanes-inl.h"
#include "engine/shared/sample_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

// Composites row by row.
class SlabCompositing {
 public:
  SlabCompositing(const SlabSums& sums, const SlabZone& zone, const RaySampling& rays, const TilePixels& tile,
                  float opacity_threshold, bool exact, Visibility& visibility)
      : sums_(sums),
        zone_(zone),
        rays_(rays),
        tile_(tile),
        opacity_threshold_(opacity_threshold),
        exact_(exact),
        visibility_(visibility),
        has_layers_(tile.aovs.any() || tile.deep != nullptr || tile.shadows != nullptr) {}

  void run() {
    for (int row = 0; row < tile_.rect.height(); ++row) compositeRow(row);
  }

 private:
  static constexpr std::size_t kLanes = hn::MaxLanes(D());

  HWY_INLINE void compositeRow(int row) {
    float* const pixels = tile_.rgba + row * tile_.stride;
    const std::size_t floats = 4 * static_cast<std::size_t>(tile_.rect.width());
    std::uint64_t closed = 0;
    bool drawn = false;
    for (int slab = 0; slab < sums_.slabs(); ++slab) {
      if (!sums_.has(slab, row)) continue;
      if (!drawn) std::fill(std::copy_n(pixels, floats, rgba_), std::end(rgba_), 0.0f);
      drawn = true;
      for (int x = 0; x < tile_.rect.width(); x += static_cast<int>(hn::Lanes(D())))
        closed |= compositeVector(slab, row, x) << x;
    }
    if (!drawn) return;
    std::copy_n(rgba_, floats, pixels);
    for (; closed != 0; closed &= closed - 1)
      rays_.close(visibility_, tile_.rect.x0 + std::countr_zero(closed), tile_.rect.y0 + row);
  }

  // Composites a vector of a row's pixels in a slab. Returns a mask of the pixels that are closed now.
  HWY_INLINE std::uint64_t compositeVector(int slab, int row, int x) {
    const D d;
    const V one = hn::Set(d, 1.0f);
    V red, green, blue, tau, pixel[4];
    hn::LoadInterleaved4(d, sums_.lightRow(slab, row) + 4 * x, red, green, blue, tau);
    hn::LoadInterleaved4(d, rgba_ + 4 * x, pixel[0], pixel[1], pixel[2], pixel[3]);
    const M adds = hn::And(hn::Gt(tau, hn::Zero(d)), hn::Ne(pixel[3], one));
    if (hn::AllFalse(d, adds)) return 0;
    const V opacity = opacityOf(d, tau);
    const V weight = hn::IfThenElseZero(adds, hn::Mul(hn::Sub(one, pixel[3]), opacity));
    const V per_depth = hn::Div(weight, hn::IfThenElse(adds, tau, one));
    const V alpha = hn::Add(pixel[3], weight);
    const M closes = hn::And(adds, hn::Ge(alpha, hn::Set(d, opacity_threshold_)));
    const V by = hn::IfThenElse(closes, alpha, one);
    V out[4] = {hn::Add(pixel[0], hn::Mul(red, per_depth)), hn::Add(pixel[1], hn::Mul(green, per_depth)),
                hn::Add(pixel[2], hn::Mul(blue, per_depth)), hn::IfThenElse(closes, one, alpha)};
    for (int c = 0; c < 3; ++c) out[c] = hn::Div(out[c], by);
    if (has_layers_) keepBefore(adds, opacity, weight, per_depth, x);
    hn::StoreInterleaved4(out[0], out[1], out[2], out[3], d, rgba_ + 4 * x);
    const std::uint64_t closed = bitsOf(d, closes);
    if (has_layers_) addLayers(slab, row, x, closed);
    return closed;
  }

  HWY_NOINLINE void keepBefore(M adds, V opacity, V weight, V per_depth, int x) {
    const D d;
    std::copy_n(rgba_ + 4 * x, 4 * hn::Lanes(d), before_);
    hn::Store(opacity, d, opacity_), hn::Store(weight, d, weight_), hn::Store(per_depth, d, per_depth_);
    adds_ = bitsOf(d, adds);
  }

  HWY_NOINLINE void addLayers(int slab, int row, int x, std::uint64_t closed) {
    const double near = zone_.near + slab * zone_.thickness;
    const int y = tile_.rect.y0 + row;
    for (std::uint64_t rest = adds_; rest != 0; rest &= rest - 1) {
      const int lane = std::countr_zero(rest), column = tile_.rect.x0 + x + lane;
      const float* const before = before_ + 4 * lane;
      const float after = (closed >> lane & 1) != 0 ? 1 : before[3] + weight_[lane];
      if (tile_.shadows != nullptr) {
        addShadow(slab, row, x + lane, before[3], after);
        continue;
      }
      SlabLayer layer;
      layer.before = before[3];
      layer.added = weight_[lane];
      layer.closes = (closed >> lane & 1) != 0;
      layer.opacity = opacity_[lane];
      layer.middle = near + 0.5 * zone_.thickness;
      layer.thickness = zone_.thickness;
      if (sums_.hasLayers()) {
        const float* const sums = sums_.layer(slab, row, x + lane);
        for (int a = 0; a < 3; ++a) layer.normal[a] = per_depth_[lane] * sums[a];
        if (exact_) {
          const double per_depth = 1 / static_cast<double>(sums_.lightRow(slab, row)[4 * (x + lane) + 3]);
          layer.middle = near + per_depth * static_cast<double>(sums[3]) * zone_.thickness;
          layer.thickness = per_depth * static_cast<double>(sums[4]) * zone_.thickness;
        }
      }
      if (tile_.aovs.any()) addLayer(layer, tile_.aovs, tile_.placeOf(column, y));
      const double from = exact_ ? layer.middle - 0.5 * layer.thickness : near;
      if (tile_.deep != nullptr)
        tile_.deep->add(column, y, static_cast<float>(from), static_cast<float>(from + layer.thickness), before,
                        rgba_ + 4 * (x + lane));
    }
  }

  // Adds the slab to a shadow map: as a whole, or its parts apart where surfaces cross the slab. The shadow of a part
  // begins behind the part, so that no surface shades itself.
  void addShadow(int slab, int row, int column, float before, float after) {
    const int x = tile_.rect.x0 + column, y = tile_.rect.y0 + row;
    const double near = zone_.near + slab * zone_.thickness;
    const auto add = [&](double from, double thickness, float alpha) {
      tile_.shadows->add(x, y, static_cast<float>(from), static_cast<float>(from + thickness), before, alpha);
      before = alpha;
    };
    const float* const shade = exact_ ? sums_.layer(slab, row, column) : nullptr;
    if (shade == nullptr || shade[SlabSums::kParts] == 0) return add(near, zone_.thickness, after);
    const double part_thickness = zone_.thickness / SlabSums::kParts;
    const float first = before;
    float depth = 0;
    int last = SlabSums::kParts - 1;
    while (last > 0 && shade[last] == 0) --last;
    for (int part = 0; part <= last; ++part) {
      depth += shade[part];
      if (shade[part] > 0)
        add(near + (part + 1) * part_thickness, part_thickness,
            part == last ? after : 1 - (1 - first) * std::exp(-depth));
    }
  }

  const SlabSums& sums_;
  const SlabZone& zone_;
  const RaySampling& rays_;
  const TilePixels& tile_;
  const float opacity_threshold_;
  const bool exact_;
  Visibility& visibility_;
  const bool has_layers_;                    // samples are kept beyond their light
  alignas(64) float rgba_[4 * kSquareEdge];  // the row's pixels
  // A vector of pixels before a slab, and the slab's contribution.
  alignas(64) float before_[4 * kLanes], opacity_[kLanes], weight_[kLanes], per_depth_[kLanes];
  std::uint64_t adds_ = 0;
};

void compositeSlabsOn(const SlabSums& sums, const SlabZone& zone, const RaySampling& rays, const TilePixels& tile,
                      float opacity_threshold, bool exact, Visibility& visibility) {
  SlabCompositing(sums, zone, rays, tile, opacity_threshold, exact, visibility).run();
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {

HWY_EXPORT(compositeSlabsOn);

void compositeSlabs(const SlabSums& sums, const SlabZone& zone, const RaySampling& rays, const TilePixels& tile,
                    float opacity_threshold, bool exact, Visibility& visibility) {
  HWY_DYNAMIC_DISPATCH(compositeSlabsOn)(sums, zone, rays, tile, opacity_threshold, exact, visibility);
}

}  // namespace kiln
#endif
