// The voxels of a unit on their way from the brick to where it is refined.
#pragma once

#include <array>

#include "splat/refine_unit.h"
#include "store/brick_block.h"

namespace kiln {

/// What samples interpolate.
struct SampledRange {
  ValueRange values;
  bool gaps = false;  // whether there is NaN among them
};

/// What the samples of a unit interpolate, and where its two blocks along x are judged apart, those of each.
struct UnitRanges {
  SampledRange whole;
  std::array<SampledRange, 2> blocks;
};

/// Writes the unit's voxels and those around it to `values`, less `offset`; returns the ranges of what its samples
/// interpolate. `lo` is the unit's first voxel. Voxels that the brick has not, which no sample of its needs, repeat the
/// nearest. shape: `values` as UnitInput's, 64-byte aligned. requires: for types of up to 16 bits, `offset` is whole.
UnitRanges loadUnit(const BrickBlock& block, const UnitLattice& lattice, double offset, const VoxelCoord& lo,
                    float* values);

}  // namespace kiln
