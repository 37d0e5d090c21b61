// Splats the voxels of one cell into one tile, front to back.
// Problem. Voxels behind closed pixels must cost neither gradient nor light.
// Method. Per voxel: classify, project, test visibility, shade, accumulate, close pixels.
// Source: Lee and Ihm §2.
#pragma once

#include <cstdint>

#include "engine/engine.h"
#include "engine/shared/classifier.h"
#include "engine/shared/draw_counts.h"
#include "engine/shared/end_voxels.h"
#include "engine/shared/gradient_opacity.h"
#include "engine/shared/projector.h"
#include "engine/shared/shade.h"
#include "engine/voxel/project_voxels.h"
#include "engine/voxel/tile_planes.h"
#include "scene/clip_region.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// Parameters that all bricks of a level share in a frame.
struct SplatContext {
  const Projector* projector = nullptr;
  EndVoxels ends;
  Shader shader;
  bool light_is_plain = true;  // the light of `view` suffices; otherwise `shader` computes colours
  VoxelView view;
  GradientOpacity gradient_opacity;
  const ClipRegion* clip = nullptr;
  VoxelBox part = ClipRegion::Part().voxels();  // voxels of the level that are drawn
  const Classifier* classifier = nullptr;
  bool test_samples = false;  // skip voxels whose pixels are all closed, before shading
};

/// Splats the voxels of `cell` that lie in the context's part into `planes`, which hold pixels of the target's tile. A
/// pixel's result does not depend on the tile's rectangle. requires: cell inside block.core, at most kSplatCellSize
/// voxels along an axis.
void splatCell(const SplatContext& context, const BrickBlock& block, const VoxelBox& cell, const TileTarget& target,
               TilePlanes& planes, DrawCounts& counts) noexcept;

}  // namespace kiln
