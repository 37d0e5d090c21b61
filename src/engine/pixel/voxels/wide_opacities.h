// Opacities of a cell's voxels with a wide margin, smoothed for the gradients of labels and masks.
#pragma once

#include "engine/pixel/voxels/load_patch.h"

namespace kiln {

/// Reach of the opacity smoothing, at most and at least. A reach of 1 shows rings on a ball whose voxels are a pixel.
/// unit: voxels.
inline constexpr int kMostLabelSmoothing = 3, kLeastLabelSmoothing = 2;

struct WideOpacities {
  static constexpr int kEdge = kPatchEdge, kWide = kEdge + 2 * kMostLabelSmoothing;
  /// Opacities before and during smoothing. shape: kWide per axis.
  float values[2][kWide * kWide * kWide];

  /// The opacity of a voxel, counted from the patch's first voxel less the reach of the smoothing.
  float& at(std::size_t i, std::size_t j, std::size_t k) {
    return values[0][(k * static_cast<std::size_t>(kWide) + j) * static_cast<std::size_t>(kWide) + i];
  }
  /// Smooths the opacities of the patch and `reach` voxels around it, by binomial weights. shape: `out` as loadPatch's.
  void smooth(int reach, float* out);
};

}  // namespace kiln
