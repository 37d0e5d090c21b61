// Footprints of voxels over the pixels of a tile, one after the other, front to back: light, weights, opacities,
// blending; the last of the kernels of `--lattice voxel`. A footprint's weights sum to one over all of its
// pixels, in the tile or not: they are those of a table (engine/voxel/voxel_footprint.h) where there is one, else found
// pixel by pixel and divided by their sum. Eight or sixteen pixels are a vector when weights and opacities are found,
// eight of a row when they are blended. One implementation in Highway, without approximate operations, fused where it
// says so, sums in an order that no vector's length changes: all instruction sets give the same bits.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "engine/shared/classifier.h"
#include "engine/voxel/project_voxels.h"
#include "engine/voxel/tile_planes.h"
#include "occlusion/visibility.h"

namespace kiln {

/// What a voxel tells beside its colour.
struct VoxelAov {
  float depth;       // unit: world
  glm::vec3 normal;  // in view space, of unit length or 0
};

/// A batch of voxels whose places are known. shape: a number a voxel.
struct ShadedVoxels {
  alignas(64) float material[4 * kVoxelBatch];  // r, g, b and extinction of each, less where it exists in part
  alignas(64) float slope[3][kVoxelBatch];  // value's gradient in index space; 0: the material's colour is the voxel's
  VoxelAov aov[kVoxelBatch];                // where the tile has AOVs
};

/// Draws those of the voxels that have their bit in `drawn` into what `planes` holds. A pixel that reaches the alpha
/// `opaque_at`, above 0, is divided by it and closed, so that its alpha of one lets nothing more in, whatever the
/// visibility method. A pixel's result does not depend on the tile's rectangle.
void rasterizeFootprints(const VoxelView& view, const ProjectedVoxels& voxels, const ShadedVoxels& shaded,
                         std::uint32_t drawn, TilePlanes& planes, float opaque_at, Visibility& visibility) noexcept;

}  // namespace kiln
