// Loads the voxels of a cell and its margin from a brick into a dense array of floats for the interpolating kernel.
#pragma once

#include "engine/pixel/voxels/sample_lattice.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// Edge of a cell. unit: voxels.
inline constexpr int kPatchVoxels = 8;
/// Margin read around a cell: a voxel for linear interpolation and a voxel for the gradient, or two for a cubic and the
/// gradient. unit: voxels.
inline constexpr int kPatchMargin = 2;
/// Edge of the voxels read for a cell, margin included. unit: voxels.
inline constexpr int kPatchEdge = kPatchVoxels + 2 * kPatchMargin;
/// Distance of rows in the dense array: a row is whole vectors. unit: floats.
inline constexpr int kPatchStride = 16;

/// Range of the voxels that samples interpolate.
struct SampledRange {
  ValueRange values;
  bool gaps = false;  // some voxels are NaN
};

/// Loads a cell and its margin into `values`, with `offset` subtracted. Returns the range of the voxels that the cell's
/// samples interpolate. `lo` is the cell's first voxel. Voxels outside the brick, which none of its samples needs,
/// repeat the nearest voxel. shape: `values` has kPatchVoxels + 2 kPatchMargin voxels along each axis, rows of
/// kPatchStride, 64-byte aligned. requires: for types of up to 16 bits, `offset` is a whole number.
SampledRange loadPatch(const BrickBlock& block, const SampleLattice& lattice, double offset, const VoxelCoord& lo,
                       float* values);

/// Computes the offsets in a brick's arrays of `count` voxels along an axis from voxel `first` on. Voxels outside the
/// brick, which none of its samples needs, repeat the nearest voxel.
void voxelOffsets(const BrickBlock& block, int axis, std::int64_t first, int count, std::int64_t* out);

/// Name of the instruction set in use, such as "AVX3".
const char* instructionSet();

}  // namespace kiln
