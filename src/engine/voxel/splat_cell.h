// Splats the voxels of one cell into one tile, front to back.
// Problem. Voxels behind closed pixels must cost neither gradient nor light.
// Method. Per voxel: classify, project, test visibility, shade, accumulate, close pixels.
// Source: Lee and Ihm §2.
#pragma once

#include <cstdint>

#include "engine/shared/classifier.h"
#include "engine/shared/draw_counts.h"
#include "engine/shared/end_voxels.h"
#include "engine/shared/gradient_opacity.h"
#include "engine/shared/projector.h"
#include "engine/shared/shade.h"
#include "engine/voxel/project_voxels.h"
#include "engine/voxel/tile_planes.h"
#include "occlusion/visibility.h"
#include "scene/clip_region.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// Parameters that all cells of a brick share.
struct SplatContext {
  const Projector* projector = nullptr;         // belongs to the brick's level
  EndVoxels ends;                               // belongs to the brick's level
  Shader shader;                                // belongs to the brick's level
  bool light_is_plain = true;                   // the light of `view` suffices; otherwise `shader` computes colours
  VoxelView view;                               // belongs to the brick's level
  GradientOpacity gradient_opacity;             // belongs to the brick's level
  const ClipRegion* clip = nullptr;             // belongs to the brick's level
  VoxelBox part = ClipRegion::Part().voxels();  // voxels of the level that are drawn
  const Classifier* classifier = nullptr;
  float opaque_at = 1;  // alpha at which a pixel is closed
  Visibility* visibility = nullptr;
  bool test_samples = false;  // skip voxels whose pixels are all closed, before shading
};

/// Splats the voxels of `cell` that lie in the frame's part into the tile. A pixel's result does not depend on the
/// tile's rectangle. requires: cell inside block.core, at most kSplatCellSize voxels along an axis.
void splatCell(const SplatContext& frame, const BrickBlock& block, const VoxelBox& cell, TilePlanes& planes,
               DrawCounts& counts) noexcept;

}  // namespace kiln
