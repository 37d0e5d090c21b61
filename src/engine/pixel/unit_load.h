// The voxels of a cell, and those around it, on their way from the brick to the kernel that interpolates them.
#pragma once

#include "engine/pixel/sample_lattice.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// Voxels along an axis of a cell.
inline constexpr int kUnitVoxels = 8;
/// Voxels that are read around a cell: one for linear interpolation and one for its gradient, or two for a cubic, whose
/// gradient takes the same.
inline constexpr int kUnitMargin = 2;
/// Floats from row to row of what is read: a row is whole vectors.
inline constexpr int kUnitSamples = 16;

/// What samples interpolate.
struct SampledRange {
  ValueRange values;
  bool gaps = false;  // whether there is NaN among them
};

/// Writes the cell's voxels and those around it to `values`, less `offset`; returns the range of what its samples
/// interpolate. `lo` is the cell's first voxel. Voxels that the brick has not, which no sample of its needs, repeat the
/// nearest. shape: `values` has voxels and two margins along each axis, rows of kUnitSamples, 64-byte aligned.
/// requires: for types of up to 16 bits, `offset` is whole.
SampledRange loadUnit(const BrickBlock& block, const SampleLattice& lattice, double offset, const VoxelCoord& lo,
                      float* values);

/// The instruction set of kernels in use: "AVX3" and the like.
const char* instructionSet();

}  // namespace kiln
