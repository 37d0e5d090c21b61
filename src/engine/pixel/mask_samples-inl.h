// Samples of a volume of which a mask shows a part: shares of shown voxels, and normals at the surface of the mask.
// README.md, equation (13). Compiled once for each instruction set; hence no #pragma once.
#if defined(KILN_MASK_SAMPLES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_MASK_SAMPLES_INL_H
#undef KILN_MASK_SAMPLES_INL_H
#else
#define KILN_MASK_SAMPLES_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>

#include "engine/pixel/cast_rays_in_cell.h"
#include "engine/pixel/cell_field-inl.h"
#include "engine/pixel/voxels/label_voxels.h"
#include "engine/pixel/voxels/mask_voxels.h"
#include "engine/shared/sample_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

class MaskSamples {
 public:
  MaskSamples(const SampleLattice& lattice, const CellInput& in, CellSamples& samples)
      : l_(lattice), in_(in), s_(samples) {}

  // Share of the visible samples from the n-th on that the mask shows, solid as a label is (labelPlace).
  HWY_NOINLINE V shownAt(std::size_t n, std::size_t count) const {
    const D d;
    alignas(64) float out[CellSamples::kLanes] = {};
    for (std::size_t i = 0; i < count; ++i) {
      const auto sample = static_cast<std::size_t>(s_.index[n + i]);
      out[i] = solidOf(interpolatedAt(in_.mask, s_, sample));
    }
    return hn::Load(d, out);
  }

  // Finds the gradients of the mask's share for a batch of samples, and keeps them: the field uses the rows of
  // CellSamples next.
  HWY_NOINLINE void findSlopes(std::size_t n, std::size_t count) {
    const D d;
    CubicCellField share(l_, in_.mask_smoothed, s_);
    share.findSlopes(n, count);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
      const Vector slope = share.slopes(i);
      hn::StoreU(slope.x, d, slope_[0] + i);
      hn::StoreU(slope.y, d, slope_[1] + i);
      hn::StoreU(slope.z, d, slope_[2] + i);
    }
  }

  // Gradients that give the normals of a vector of samples, the i-th of findSlopes on: the mask's at its surface,
  // otherwise `slope`.
  HWY_NOINLINE Vector slopesOr(const Vector& slope, std::size_t i) const {
    const D d;
    const V x = hn::LoadU(d, slope_[0] + i), y = hn::LoadU(d, slope_[1] + i), z = hn::LoadU(d, slope_[2] + i);
    const V squared = hn::Add(hn::Mul(x, x), hn::Add(hn::Mul(y, y), hn::Mul(z, z)));
    const M edge = hn::Gt(squared, hn::Set(d, kMaskEdge * kMaskEdge));
    const V length = hn::Sqrt(hn::IfThenElse(edge, squared, hn::Set(d, 1.0f)));
    const V factor = hn::Div(hn::Set(d, l_.light.gradient.directed), length);
    const auto either = [&](V of_mask, V of_field) { return hn::IfThenElse(edge, hn::Mul(factor, of_mask), of_field); };
    return {either(x, slope.x), either(y, slope.y), either(z, slope.z)};
  }

 private:
  const SampleLattice& l_;
  const CellInput& in_;
  CellSamples& s_;
  alignas(64) float slope_[3][CellSamples::kLit + CellSamples::kLanes];
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
