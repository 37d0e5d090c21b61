// Rasterizes the footprints of a batch of voxels into a tile, front to back: light, weights, opacities, blending.
// Method. README.md, equations (3) to (7). A footprint's weights come from a table (engine/voxel/voxel_footprint.h) if
// one exists, otherwise they are computed per pixel and divided by their sum. Weights and opacities are computed for
// eight or sixteen pixels at a time, blending takes eight pixels of a row.
// Invariant. A footprint's weights sum to one over all its pixels, inside and outside the tile. One Highway
// implementation without approximate operations, with explicit fused operations and a fixed order of sums, returns
// equal bits on all instruction sets.
// Source: Westover 1990. Differs: footprints are normalised by their sum.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "engine/shared/classifier.h"
#include "engine/voxel/project_voxels.h"
#include "engine/voxel/tile_planes.h"
#include "occlusion/visibility.h"

namespace kiln {

/// Depth and normal that a voxel contributes to AOVs.
struct VoxelAov {
  float depth;       // unit: world
  glm::vec3 normal;  // view space, unit length or 0
};

/// Materials and gradients of a batch of projected voxels. shape: one number per voxel.
struct ShadedVoxels {
  alignas(64) float material[4 * kVoxelBatch];  // r, g, b, extinction; extinction is scaled if a voxel exists in part
  alignas(64) float slope[3][kVoxelBatch];      // gradient in index space; 0: the material's colour is used unlit
  VoxelAov aov[kVoxelBatch];                    // only if the tile has AOVs
};

/// Draws the voxels whose bit is set in `drawn` into `planes`. A pixel whose alpha reaches `opacity_threshold` (above
/// 0) is divided by its alpha and closed. Its alpha of one then blocks all later voxels under every visibility method.
/// A pixel's result does not depend on the tile's rectangle.
void rasterizeFootprints(const VoxelView& view, const ProjectedVoxels& voxels, const ShadedVoxels& shaded,
                         std::uint32_t drawn, TilePlanes& planes, float opacity_threshold,
                         Visibility& visibility) noexcept;

}  // namespace kiln
