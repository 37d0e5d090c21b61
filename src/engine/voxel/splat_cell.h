// The kernel of `--lattice voxel`: the voxels of one cell, each once, front to back, as footprints into one tile. This
// is Lee and Ihm's algorithm to the letter: classify, test, shade, project, accumulate, update.
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

/// What all cells of a brick share.
struct SplatContext {
  const Projector* projector = nullptr;         // of the brick's level
  EndVoxels ends;                               // the same
  Shader shader;                                // the same
  bool light_is_plain = true;                   // what `view` has; else colours are the shader's
  VoxelView view;                               // the same
  GradientOpacity gradient_opacity;             // the same
  const ClipRegion* clip = nullptr;             // the same
  VoxelBox part = ClipRegion::Part().voxels();  // voxels that are drawn, of the level
  const Classifier* classifier = nullptr;
  float opaque_at = 1;  // alpha at which a pixel is closed
  Visibility* visibility = nullptr;
  bool test_samples = false;  // leave out samples all of whose pixels are closed, before they are shaded
};

/// Splats the voxels of `cell` into the tile. requires: cell inside block.core, at most kSplatCellSize voxels along an
/// axis. Voxels outside of the frame's part are not drawn.
/// The result for a pixel does not depend on the tile's rectangle.
void splatCell(const SplatContext& frame, const BrickBlock& block, const VoxelBox& cell, TilePlanes& planes,
               DrawCounts& counts) noexcept;

}  // namespace kiln
