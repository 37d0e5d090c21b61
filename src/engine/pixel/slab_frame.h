// What all bricks and tiles of a zone of slabs share, made once a frame, and which cells of a brick the transfer
// function shows there.
#pragma once

#include <vector>

#include "engine/pixel/sample_table.h"
#include "engine/pixel/unit_load.h"
#include "engine/shared/end_voxels.h"
#include "engine/shared/gradient_opacity.h"
#include "engine/shared/shade.h"
#include "engine/shared/slab_grid.h"
#include "scene/clip_region.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// How samples of a level look beside what the table says. requires: all outlive those who have it.
struct Appearance {
  Shading shading;
  Shader shader;  // of the level
  GradientOpacity gradient_opacity;
  const ClipRegion* clip = nullptr;
  float gradient_noise = 0;  // unit: value per voxel
  Interpolation interpolation = Interpolation::kLinear;
};

/// What all bricks and tiles of a zone share.
class SlabFrame {
 public:
  /// requires: all outlive this; `projector` is of the zone's level, `dims` its voxels.
  SlabFrame(const SlabZone& zone, const Projector& projector, const Extent3& dims, const EndVoxels& ends,
            const SampleTable& table, const Appearance& look);

  const SlabZone& zone() const { return zone_; }
  const Projector& projector() const { return projector_; }
  const Extent3& dims() const { return dims_; }
  const EndVoxels& ends() const { return ends_; }
  const SampleTable& table() const { return table_; }
  /// Whether samples that interpolate values of `range`, or stand for some of them, may show anything.
  bool interesting(const ValueRange& range) const { return table_.interesting(range); }
  /// Whether nothing of the samples in the voxels' cubes is in the clip region, or in the part that is drawn.
  bool cutOff(const VoxelBox& samples) const;
  /// Whether two samples of a cell may be one, twice as long, that interpolate `range`.
  bool inPairs(const SampledRange& range) const;
  const Appearance& look() const { return look_; }
  /// Whether samples are shaded, modulated and clipped one by one, instead of by the vector.
  bool detailed() const { return detailed_; }
  const SampleLattice& lattice() const { return lattice_; }

  /// Pixels whose rays may have samples of the zone in the voxels' cubes, and perhaps more; not cut off at the image.
  PixelRect boundsOf(const VoxelBox& box) const;

 private:
  const SlabZone& zone_;
  const Projector& projector_;
  const Extent3 dims_;
  const EndVoxels ends_;
  const SampleTable& table_;
  Appearance look_;
  bool detailed_;
  SampleLattice lattice_;
  double voxel_length_;   // the mean of its edges. unit: world
  double shortest_edge_;  // the same
};

/// A cell of a brick that may hold something, and the pixels it may be seen in.
struct SlabCell {
  VoxelBox box;
  PixelRect rect;
};

/// The cells of the brick that the transfer function shows, front to back. cost: a look at each cell's range; for a
/// cubic also at the voxels of cells beside one that is shown.
std::vector<SlabCell> visibleCells(const SlabFrame& frame, const BrickBlock& block);

}  // namespace kiln
