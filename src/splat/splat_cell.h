// The kernel of `--lattice voxel`: the voxels of one cell, each once, front to back, as footprints into one tile. This
// is Lee and Ihm's algorithm to the letter: classify, test, shade, project, accumulate, update.
#pragma once

#include <cstdint>

#include "occlusion/visibility.h"
#include "scene/clip_region.h"
#include "splat/classifier.h"
#include "splat/gradient_opacity.h"
#include "splat/project_voxels.h"
#include "splat/projector.h"
#include "splat/shade.h"
#include "splat/tile_planes.h"
#include "store/brick_block.h"

namespace kiln {

/// Where a coarser level ends: the last voxel along an axis covers only a part of its length where the volume's extent
/// is no multiple of a coarse voxel, and holds so much less material.
struct EndVoxels {
  VoxelCoord last{-1, -1, -1};
  glm::dvec3 part{1};
  bool any() const { return part != glm::dvec3(1); }
  double partOf(const VoxelCoord& v) const {
    return (v.x == last.x ? part.x : 1) * (v.y == last.y ? part.y : 1) * (v.z == last.z ? part.z : 1);
  }
};

/// What all cells of a brick share.
struct SplatFrame {
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

struct SplatCounts {
  std::uint64_t visited = 0;  // interesting voxels, or samples, with their centre in the tile
  std::uint64_t splats = 0;   // those of them that were drawn
  std::uint64_t nodes_tested = 0, nodes_hidden = 0;
  bool changed = false;  // whether a pixel may be another than before
  void add(const SplatCounts& other) {
    visited += other.visited;
    splats += other.splats;
    nodes_tested += other.nodes_tested;
    nodes_hidden += other.nodes_hidden;
    changed = changed || other.changed;
  }
};

/// Splats the voxels of `cell` into the tile. requires: cell inside block.core, at most kSplatCellSize voxels along an
/// axis. Voxels outside of the frame's part are not drawn.
/// The result for a pixel does not depend on the tile's rectangle.
void splatCell(const SplatFrame& frame, const BrickBlock& block, const VoxelBox& cell, TilePlanes& planes,
               SplatCounts& counts) noexcept;

}  // namespace kiln
