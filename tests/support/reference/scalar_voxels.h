// Kernels of the voxel lattice as plain loops, voxel by voxel and pixel by pixel: the truth for every instruction set,
// and the baseline of benchmarks.
#pragma once

#include "engine/voxel/rasterize_footprints.h"

namespace kiln::test {

/// projectVoxels.
void projectVoxelsScalar(const VoxelView& view, const VoxelCoord& lo, const std::int32_t* codes, int count,
                         const PixelRect& tile, ProjectedVoxels& out);

/// rasterizeFootprints.
void layVoxelsScalar(const VoxelView& view, const ProjectedVoxels& voxels, const ShadedVoxels& shaded,
                     std::uint32_t drawn, const TilePixels& tile, float opacity_threshold, Visibility& visibility);

}  // namespace kiln::test
