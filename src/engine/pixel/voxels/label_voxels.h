// Voxels of a cell of a label volume.
// Problem. Labels are names; a number between two labels has no meaning. Whole-voxel steps would be visible in the
// shading.
// Method. Each label is interpolated by itself: 1 in its voxels, 0 elsewhere. A point is solid if the interpolated
// shares of all visible labels sum to at least a half; its label is the label with the largest share. Surfaces are
// smooth between voxels whatever lies on the other side, and have no gap where several labels meet. Gradients are taken
// from smoothed opacities; the smoothing reaches farther where voxels are larger in the picture. A voxel that a mask
// hides has no visible label.
#pragma once

#include <algorithm>
#include <cstdint>

#include "engine/pixel/voxels/load_patch.h"
#include "engine/pixel/voxels/sample_table.h"
#include "engine/pixel/voxels/wide_opacities.h"
#include "scene/transfer/label_styles.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// Voxels of a cell with a margin.
struct LabelVoxels {
  static constexpr int kEdge = WideOpacities::kEdge;
  /// Per voxel: rank of the label among the visible labels (-1: not visible); opacity of the label, smoothed. shape: as
  /// loadPatch's.
  alignas(64) std::int32_t ranks[kEdge * kEdge * kPatchStride];
  alignas(64) float opacities[kEdge * kEdge * kPatchStride];
  WideOpacities wide;
};

/// Labels of the voxels read by samples and gradients: none visible, a single visible label, or several.
enum class LabelsAround { kNone, kOne, kSeveral };

/// Loads the cell whose first voxel is `lo`. Writes all of `out` for several labels, only the ranks for one. thread:
/// safe.
LabelsAround loadLabels(const BrickBlock& block, const SampleLattice& lattice, const VoxelCoord& lo,
                        const SampleTable& table, LabelVoxels& out);

/// Solidity, 0 to 1, of a point whose visible voxels have a share of `shown`.
inline float solidOf(float shown) { return std::min(std::max(0.5f + kLabelRise * (shown - 0.5f), 0.0f), 1.0f); }

/// Table position of a sample: `shown` is the share of visible labels, `rank` the label with the largest share. Rounded
/// to steps of 1/128, which a float represents exactly for every rank: other labels change no bit.
inline float labelPlace(float shown, int rank) {
  constexpr float kSteps = 128;
  const float solid = static_cast<float>(static_cast<int>(solidOf(shown) * kSteps + 0.5f)) / kSteps;
  return solid > 0 ? SampleTable::placeOf(rank, solid) : 0.0f;
}

}  // namespace kiln
