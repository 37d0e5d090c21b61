// The voxels of a cell of a label volume. Labels are names, and no number between two of them means anything: the value
// that is interpolated is, for each label, 1 in its voxels and 0 elsewhere. A place is solid where half and more of the
// interpolated voxels is shown, and has the label with the largest share. So surfaces run smoothly between voxels,
// whatever lies on their other side, and none has a gap where several meet.
//
// Steps of whole voxels would be seen in the shading. Gradients are therefore of opacities that are smoothed before:
// the farther, the larger voxels are in the picture.
#pragma once

#include <algorithm>
#include <cstdint>

#include "engine/pixel/sample_table.h"
#include "engine/pixel/unit_load.h"
#include "scene/transfer/label_styles.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// The most and the fewest voxels to either side over which a label's opacities are smoothed: with one voxel a ball
/// whose voxels are a pixel shows rings.
inline constexpr int kMostLabelSmoothing = 3, kLeastLabelSmoothing = 2;

/// The voxels of a cell and those around it.
struct LabelVoxels {
  static constexpr int kEdge = kUnitVoxels + 2 * kUnitMargin, kWide = kEdge + 2 * kMostLabelSmoothing;
  /// Of each voxel, which of the labels shown it is, and its label's opacity, smoothed. shape: as loadUnit's.
  alignas(64) std::int32_t ranks[kEdge * kEdge * kUnitSamples];
  alignas(64) float opacities[kEdge * kEdge * kUnitSamples];
  // Opacities before and while they are smoothed. shape: kWide an axis.
  float smoothed[2][kWide * kWide * kWide];
};

/// Whether all voxels that samples and their gradients take are of no label that is shown, or of the same one.
enum class LabelsAround { kNone, kOne, kSeveral };

/// Writes what the voxels of the cell are whose first voxel is `lo`: with several labels all of `out`, with one the
/// ranks. thread: safe.
LabelsAround loadLabels(const BrickBlock& block, const SampleLattice& lattice, const VoxelCoord& lo,
                        const SampleTable& table, LabelVoxels& out);

/// The place in the table of a sample of which so much is shown, of that label the most. In whole steps, which a place
/// keeps for every rank: which others there are changes no bit.
inline float labelPlace(float shown, int rank) {
  constexpr float kSteps = 128;
  const float rise = std::min(std::max(0.5f + kLabelRise * (shown - 0.5f), 0.0f), 1.0f);
  const float solid = static_cast<float>(static_cast<int>(rise * kSteps + 0.5f)) / kSteps;
  return solid > 0 ? SampleTable::placeOf(rank, solid) : 0.0f;
}

}  // namespace kiln
