// The voxels and the samples of a unit of a label volume. Labels are names, and no number between two of them means
// anything: what is interpolated is, of each label, 1 in its voxels and 0 elsewhere. A place is solid where half and
// more of what is interpolated there is shown, and of those labels it is the one that has the most. So surfaces run
// smoothly between voxels, whatever lies on their other side, and none has a gap where several meet. At a voxel's
// centre it is the voxel's own label.
//
// Steps of whole voxels would be seen in the shading. Gradients are therefore of opacities that are smoothed before, as
// far as the apron reaches beyond the samples that a brick draws: the farther, the larger voxels are in the picture.
#pragma once

#include <algorithm>
#include <cstdint>

#include "scene/label_looks.h"
#include "splat/refine_unit.h"
#include "splat/sample_table.h"
#include "store/brick_block.h"

namespace kiln {

/// The most voxels to either side over which a label's opacities are smoothed; and on rays the fewest, with one of
/// which a ball whose voxels are a pixel shows rings.
inline constexpr int kMostLabelSmoothing = 3, kLeastLabelSmoothing = 2;

/// The voxels of a unit and those around it.
struct LabelVoxels {
  static constexpr int kEdge = kUnitVoxels + 2 * kUnitMargin, kWide = kEdge + 2 * kMostLabelSmoothing;
  /// Of each voxel, which of the labels shown it is, and its label's opacity, smoothed. shape: as UnitInput's values.
  alignas(64) std::int32_t ranks[kEdge * kEdge * kUnitSamples];
  alignas(64) float opacities[kEdge * kEdge * kUnitSamples];
  // Opacities before and while they are smoothed. shape: kWide an axis.
  float smoothed[2][kWide * kWide * kWide];
};

struct LabelSamples {
  LabelVoxels voxels;
  /// Of each sample, its place in the table. shape: rows of kUnitSamples, planes of as many rows.
  alignas(64) float places[kUnitSamples * kUnitSamples * kUnitSamples];
};

/// Whether all voxels that samples and their gradients take are of no label that is shown, or of the same one.
enum class LabelsAround { kNone, kOne, kSeveral };

/// Writes what the voxels of the unit are whose first voxel is `lo`: with several labels all of `out`, with one the
/// ranks. thread: safe.
LabelsAround loadLabels(const BrickBlock& block, const UnitLattice& lattice, const VoxelCoord& lo,
                        const SampleTable& table, LabelVoxels& out);

/// The place in the table of a sample of which so much is shown, of that label the most. In whole steps, which a place
/// keeps for every rank: which others there are changes no bit.
inline float labelPlace(float shown, int rank) {
  constexpr float kSteps = 128;
  const float rise = std::min(std::max(0.5f + kLabelRise * (shown - 0.5f), 0.0f), 1.0f);
  const float solid = static_cast<float>(static_cast<int>(rise * kSteps + 0.5f)) / kSteps;
  return solid > 0 ? SampleTable::placeOf(rank, solid) : 0.0f;
}

/// Writes what the samples of `unit` are, whose first voxel is `lo`; false where no label of them is shown, and then
/// `out` says nothing. Catmull-Rom, whose weights below zero mean nothing here, is linear. thread: safe.
bool sampleLabels(const BrickBlock& block, const UnitLattice& lattice, const UnitInput& unit, const VoxelCoord& lo,
                  const SampleTable& table, LabelSamples& out);

}  // namespace kiln
