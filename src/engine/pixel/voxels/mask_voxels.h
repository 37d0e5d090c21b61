// Voxels of a cell as a mask shows them (ShownVoxels).
// Method. A point is shown as a point of a label volume is solid (label_voxels.h): by the share of shown voxels in its
// linear interpolation. Where the smoothed share rises, its gradient is the normal of the mask's surface and replaces
// the volume's gradient in the light of solids. Iso-surfaces have no thickness, and keep their gradients; a point of an
// iso-surface is shown by the larger share of the voxels on either side of the surface.
#pragma once

#include "engine/pixel/voxels/sample_lattice.h"
#include "engine/pixel/voxels/wide_opacities.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// Length of the gradient of a mask's smoothed share from which the gradient is the normal. unit: share per voxel.
inline constexpr float kMaskEdge = 0.1f;

struct MaskVoxels {
  /// Per voxel 1 if shown, else 0; the same, smoothed. shape: as loadPatch's.
  alignas(64) float shown[WideOpacities::kEdge * WideOpacities::kEdge * kPatchStride];
  alignas(64) float smoothed[WideOpacities::kEdge * WideOpacities::kEdge * kPatchStride];
  WideOpacities wide;
};

enum class MaskAround { kNone, kAll, kSome };

/// Loads the mask of the cell whose first voxel is `lo`. Returns whether the voxels that samples and their gradients
/// read are all hidden, all shown, or neither; writes `out` in the last case alone. requires: !block.shown.all().
/// thread: safe.
MaskAround loadMask(const BrickBlock& block, const SampleLattice& lattice, const VoxelCoord& lo, MaskVoxels& out);

}  // namespace kiln
