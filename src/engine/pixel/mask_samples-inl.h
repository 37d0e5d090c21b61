// Samples of a volume of which a mask shows a part: shares of shown voxels, and normals at the surface of the mask.
// README.md, equation (13). Compiled once for each instruction set; hence no #pragma once.
#if defined(KILN_MASK_SAMPLES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_MASK_SAMPLES_INL_H
#undef KILN_MASK_SAMPLES_INL_H
#else
#define KILN_MASK_SAMPLES_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
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

  // As shownAt, for crossings of iso-surfaces. Equation (13).
  // Problem. A segmentation by a threshold ends at the surface of the threshold: half of the voxels around each
  // crossing are hidden, and the share of all of them tells nothing. Method. The voxels on either side of the surface
  // have a share of their own; the larger one counts. Voxels two steps away count as well, so that a mask that cuts the
  // surface has a straight edge even where few of the eight voxels around a crossing are on one side.
  HWY_NOINLINE V shownOnSides(std::size_t n, std::size_t count) const {
    const D d;
    alignas(64) float out[CellSamples::kLanes] = {};
    for (std::size_t i = 0; i < count; ++i) {
      const auto sample = static_cast<std::size_t>(s_.index[n + i]);
      const float value = l_.surface_values[static_cast<std::size_t>(s_.entry[n + i])];
      // Weights are half as steep as those of interpolation.
      if (showsBeside(sample)) out[i] = solidOf(0.5f + 2 * (shareOnSides(sample, value) - 0.5f));
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
  // True if one of the eight voxels around a sample is shown. Cells and bricks beside shown voxels alone are drawn.
  bool showsBeside(std::size_t sample) const {
    const float* const at = in_.mask + s_.offset[sample];
    float sum = 0;
    for (const int z : {0, CellInput::kPlane}) {
      for (const int y : {0, kPatchStride}) sum += at[z + y] + at[z + y + 1];
    }
    return sum > 0;
  }

  // The larger of two shares of shown voxels: of the voxels with at least `value`, and of the others. A voxel's weight
  // falls linearly to 0 two voxels away along each axis.
  float shareOnSides(std::size_t sample, float value) const {
    constexpr int kReach = 4;
    float weight[3][kReach];
    for (int a = 0; a < 3; ++a) {
      const float f = s_.fraction[a][sample];
      weight[a][0] = 1 - f, weight[a][1] = 2 - f, weight[a][2] = 1 + f, weight[a][3] = f;
    }
    const std::ptrdiff_t first = s_.offset[sample] - CellInput::kPlane - kPatchStride - 1;
    float all[2] = {}, shown[2] = {};  // of the voxels below, and of the others
    for (int z = 0; z < kReach; ++z) {
      for (int y = 0; y < kReach; ++y) {
        const std::ptrdiff_t row = first + z * CellInput::kPlane + y * kPatchStride;
        const float of_row = weight[2][z] * weight[1][y];
        for (int x = 0; x < kReach; ++x) {
          const float of_voxel = of_row * weight[0][x];
          const int side = in_.values[row + x] >= value ? 1 : 0;
          all[side] += of_voxel, shown[side] += of_voxel * in_.mask[row + x];
        }
      }
    }
    float out = 0;
    for (const int side : {0, 1}) {
      if (all[side] > 0) out = std::max(out, shown[side] / all[side]);
    }
    return out;
  }

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
