#include "engine/voxel/project_voxels.h"

#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/voxel/project_voxels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/voxel/voxel_batch-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

class VoxelProjector {
  using D = hn::CappedTag<double, 8>;
  using DF = hn::Rebind<float, D>;
  using DI = hn::Rebind<std::int32_t, D>;
  using V = hn::Vec<D>;
  using VF = hn::Vec<DF>;
  using M = hn::Mask<D>;

 public:
  VoxelProjector(const VoxelView& view, const VoxelCoord& lo, const PixelRect& tile, ProjectedVoxels& out)
      : view_(view), lo_(lo), tile_(tile), out_(out) {}

  void run(const std::int32_t* codes, int count) {
    for (std::size_t n = 0; n < static_cast<std::size_t>(count); n += hn::Lanes(D())) project(codes, n);
    const std::uint32_t all = (1u << count) - 1;
    out_.touching &= all;
    out_.inside &= all;
  }

 private:
  HWY_INLINE void project(const std::int32_t* codes, std::size_t n) {
    const D d;
    const DI di;
    const auto code = hn::LoadU(di, codes + n);
    const auto axis = [&](auto shifted, std::int64_t first) {
      return hn::Add(hn::PromoteTo(d, hn::And(shifted, hn::Set(di, 15))), hn::Set(d, static_cast<double>(first)));
    };
    const V x = axis(code, lo_.x), y = axis(hn::ShiftRight<4>(code), lo_.y), z = axis(hn::ShiftRight<8>(code), lo_.z);
    const auto view = [&](int c) {
      const V plane = hn::Add(hn::Set(d, view_.origin[c]), hn::Mul(z, hn::Set(d, view_.step[2][c])));
      return hn::Add(hn::Add(plane, hn::Mul(y, hn::Set(d, view_.step[1][c]))),
                     hn::Mul(x, hn::Set(d, view_.step[0][c])));
    };
    const V px = view(0), py = view(1);
    V scale = hn::Set(d, view_.focal), half_x = hn::Set(d, static_cast<double>(view_.ellipse.half_x)),
      half_y = hn::Set(d, static_cast<double>(view_.ellipse.half_y));
    M drawn = hn::Eq(scale, scale);
    if (view_.perspective) {
      const V pz = view(2);
      drawn = hn::Ge(pz, hn::Set(d, view_.near_depth));
      const V r = hn::Div(hn::Set(d, 1.0), hn::IfThenElse(drawn, pz, hn::Set(d, 1.0)));
      scale = hn::Mul(scale, r);
      sizes(n, hn::Mul(px, r), hn::Mul(py, r), r, half_x, half_y);
    }
    const V at_x = hn::Add(hn::Set(d, view_.centre.x), hn::Mul(scale, px));
    const V at_y = hn::Add(hn::Set(d, view_.centre.y), hn::Mul(scale, py));
    // Positions far outside the image would overflow a 32-bit pixel number; such voxels touch no image.
    const V far = hn::Set(d, 1e8);
    drawn = hn::And(drawn,
                    hn::And(hn::Lt(hn::Add(hn::Abs(at_x), half_x), far), hn::Lt(hn::Add(hn::Abs(at_y), half_y), far)));
    drawn = hn::And(drawn, span(at_x, half_x, drawn, tile_.x0, tile_.x1, out_.x0 + n, out_.x1 + n, out_.dx + n));
    drawn = hn::And(drawn, span(at_y, half_y, drawn, tile_.y0, tile_.y1, out_.y0 + n, out_.y1 + n, out_.dy + n));
    out_.touching |= bitsOf(D(), drawn) << n;
    out_.inside |= bitsOf(D(), hn::And(within(at_x, tile_.x0, tile_.x1), within(at_y, tile_.y0, tile_.y1))) << n;
  }

  // Computes the footprint's variances and half extents: J C Jᵀ with J = f/z [1 0 -u; 0 1 -v], the derivative of the
  // projection, plus the pixel filter's variance. Equation (2).
  HWY_INLINE void sizes(std::size_t n, V u, V v, V r, V& half_x, V& half_y) {
    const D d;
    const DF df;
    const VF uf = hn::DemoteTo(df, u), vf = hn::DemoteTo(df, v), rf = hn::DemoteTo(df, r);
    const VF squared = hn::Mul(rf, rf);
    const float* const c = view_.covariance;
    const auto variance = [&](VF slope, float own, float mixed) {
      const VF tilted = hn::Mul(slope, hn::Sub(hn::Mul(slope, hn::Set(df, c[5])), hn::Set(df, 2 * mixed)));
      return hn::Add(hn::Mul(squared, hn::Add(hn::Set(df, own), tilted)),
                     hn::Set(df, static_cast<float>(kPixelSigma * kPixelSigma)));
    };
    const VF xx = variance(uf, c[0], c[3]), yy = variance(vf, c[2], c[4]);
    const VF radius = hn::Set(df, static_cast<float>(kFootprintRadius));
    half_x = hn::PromoteTo(d, hn::Mul(radius, hn::Sqrt(xx)));
    half_y = hn::PromoteTo(d, hn::Mul(radius, hn::Sqrt(yy)));
    hn::Store(uf, df, out_.u + n);
    hn::Store(vf, df, out_.v + n);
    hn::Store(rf, df, out_.r + n);
    hn::Store(xx, df, out_.xx + n);
    hn::Store(yy, df, out_.yy + n);
  }

  // Stores the pixels whose centres lie within `half` of `at`; pixel c has its centre at c + 1/2. Returns a mask of the
  // voxels with a pixel in the tile.
  HWY_INLINE M span(V at, V half, M drawn, int tile_first, int tile_end, std::int32_t* first, std::int32_t* end,
                    float* from_centre) {
    const D d;
    const V middle = hn::Set(d, 0.5), one = hn::Set(d, 1.0);
    const V lo = hn::IfThenElseZero(drawn, hn::Ceil(hn::Sub(hn::Sub(at, half), middle)));
    const V hi = hn::IfThenElseZero(drawn, hn::Add(hn::Floor(hn::Sub(hn::Add(at, half), middle)), one));
    hn::Store(hn::DemoteTo(DI(), lo), DI(), first);
    hn::Store(hn::DemoteTo(DI(), hi), DI(), end);
    hn::Store(hn::DemoteTo(DF(), hn::Sub(hn::Add(lo, middle), at)), DF(), from_centre);
    return hn::And(hn::Lt(hn::Max(lo, hn::Set(d, static_cast<double>(tile_first))),
                          hn::Min(hi, hn::Set(d, static_cast<double>(tile_end)))),
                   drawn);
  }

  HWY_INLINE static M within(V at, int first, int end) {
    const D d;
    return hn::And(hn::Ge(at, hn::Set(d, static_cast<double>(first))),
                   hn::Lt(at, hn::Set(d, static_cast<double>(end))));
  }

  const VoxelView& view_;
  const VoxelCoord lo_;
  const PixelRect tile_;
  ProjectedVoxels& out_;
};

void projectVoxelsOn(const VoxelView& view, const VoxelCoord& lo, const std::int32_t* codes, int count,
                     const PixelRect& tile, ProjectedVoxels& out) {
  out.touching = out.inside = 0;
  VoxelProjector(view, lo, tile, out).run(codes, count);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {

HWY_EXPORT(projectVoxelsOn);

VoxelView::VoxelView(const Projector& projector, const PlainLight& of_light)
    : perspective(projector.perspective()),
      origin(projector.viewOf({0, 0, 0})),
      step{projector.axis(0), projector.axis(1), projector.axis(2)},
      focal(projector.focal()),
      centre(projector.centre()),
      near_depth(projector.nearDepth()),
      length(static_cast<float>(projector.voxelVolume() * focal * focal)),
      light(of_light) {
  if (!perspective) {
    ellipse = projector.ellipseAt(origin);
    if (VoxelFootprint::fits(ellipse)) footprint = std::make_shared<VoxelFootprint>(ellipse);
  }
  const glm::dmat3 c = focal * focal * projector.covariance();
  const double of_axes[6] = {c[0][0], c[1][0], c[1][1], c[2][0], c[2][1], c[2][2]};
  for (int i = 0; i < 6; ++i) covariance[i] = static_cast<float>(of_axes[i]);
}

void projectVoxels(const VoxelView& view, const VoxelCoord& lo, const std::int32_t* codes, int count,
                   const PixelRect& tile, ProjectedVoxels& out) noexcept {
  HWY_DYNAMIC_DISPATCH(projectVoxelsOn)(view, lo, codes, count, tile, out);
}

}  // namespace kiln
#endif
