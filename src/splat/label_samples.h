// The samples of a unit of a label volume. Labels are names, and no number between two of them means anything: what is
// interpolated is, of each label, 1 in its voxels and 0 elsewhere. A place is solid where half and more of what is
// interpolated there is shown, and of those labels it is the one that has the most. So surfaces run smoothly between
// voxels, whatever lies on their other side, and none has a gap where several meet. At a voxel's centre it is the
// voxel's own label.
//
// Steps of whole voxels would be seen in the shading. Gradients are therefore of opacities that are smoothed before, as
// far as the apron reaches beyond the samples that a brick draws: the farther, the larger voxels are in the picture.
#pragma once

#include "splat/refine_unit.h"
#include "splat/sample_table.h"
#include "store/brick_block.h"

namespace kiln {

/// The most voxels to either side over which a label's opacities are smoothed.
inline constexpr int kMostLabelSmoothing = 3;

struct LabelSamples {
  static constexpr int kEdge = kUnitVoxels + 2 * kUnitMargin, kWide = kEdge + 2 * kMostLabelSmoothing;
  /// Of each sample, its place in the table. shape: rows of kUnitSamples, planes of as many rows.
  alignas(64) float places[kUnitSamples * kUnitSamples * kUnitSamples];
  /// Of each voxel its label's opacity, smoothed. shape: as UnitInput's values.
  alignas(64) float opacities[kEdge * kEdge * kUnitSamples];
  // The unit's voxels and those around it that smoothing takes: which of the labels shown each is. shape: kWide an
  // axis.
  int ranks[kWide * kWide * kWide];
  float smoothed[2][kWide * kWide * kWide];
};

/// Writes what the samples of `unit` are, whose first voxel is `lo`; false where no label of them is shown, and then
/// `out` says nothing. Catmull-Rom, whose weights below zero mean nothing here, is linear. thread: safe.
bool sampleLabels(const BrickBlock& block, const UnitLattice& lattice, const UnitInput& unit, const VoxelCoord& lo,
                  const SampleTable& table, LabelSamples& out);

}  // namespace kiln
