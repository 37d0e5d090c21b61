// What all bricks and tiles of a zone of slabs share, made once a frame, and which cells of a brick the transfer
// function shows there.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "scene/clip_region.h"
#include "splat/gradient_opacity.h"
#include "splat/sample_table.h"
#include "splat/shade.h"
#include "splat/sheet.h"
#include "splat/slab_grid.h"
#include "splat/splat_cell.h"
#include "splat/unit_load.h"
#include "store/brick_block.h"

namespace kiln {

/// How far beyond its core a brick's samples are drawn, at most: the apron, but for a voxel that gradients (and the
/// B-spline) need. unit: voxels.
inline constexpr std::int64_t kMostGhosts = 5;

/// How samples of a level look beside what the table says. requires: all outlive those who have it.
struct SampleLook {
  Shading shading;
  Shader shader;  // of the level
  GradientOpacity gradient_opacity;
  const ClipRegion* clip = nullptr;
  float gradient_noise = 0;  // unit: value per voxel
  Interpolation interpolation = Interpolation::kLinear;
};

/// How a brick's slabs come about.
struct SlabSharing {
  /// Each brick draws the samples of its apron, too, and takes those pixels of slabs that it owns; else all bricks that
  /// reach into a slab are drawn together, each its own samples.
  bool owned = true;
  int least_taps = 0;    // of footprints: of all that are drawn together the same
  float color_unit = 1;  // see colorUnitOf: the same, and no less than the frame's own
};

/// What all bricks and tiles of a zone share.
class SlabFrame {
 public:
  /// requires: all outlive this; `projector` is of the zone's level, `dims` its voxels.
  SlabFrame(const SlabZone& zone, const Projector& projector, const Extent3& dims, const EndVoxels& ends,
            const SampleTable& table, const SampleLook& look, const SlabSharing& sharing = {});

  const SlabZone& zone() const { return zone_; }
  const Projector& projector() const { return projector_; }
  const Extent3& dims() const { return dims_; }
  const EndVoxels& ends() const { return ends_; }
  const SampleTable& table() const { return table_; }
  /// Whether samples that interpolate values of `range`, or stand for some of them, may show anything.
  bool interesting(const ValueRange& range) const { return table_.interesting(range); }
  /// Whether a block of voxels (softBlock) has the samples of `softLattice`, which then interpolate `range`. requires:
  /// a soft lattice.
  bool soft(const VoxelBox& block, const SampledRange& range) const;
  /// Whether nothing of the samples in the voxels' cubes is in the clip region.
  bool cutOff(const VoxelBox& samples) const;
  /// On rays: whether two samples of a cell may be one, twice as long, that interpolate `range`.
  bool inPairs(const SampledRange& range) const;
  const SampleLook& look() const { return look_; }
  /// Whether samples are shaded, modulated and clipped one by one, instead of by the vector.
  bool detailed() const { return detailed_; }
  const FootprintTable& footprint() const { return footprint_; }
  /// See colorUnitOf: that of all volumes.
  float colorUnit() const { return color_unit_; }
  const UnitLattice& lattice() const { return lattice_; }
  /// Null where all voxels have the same. Both have the same units.
  const UnitLattice* softLattice() const { return soft_lattice_ ? &*soft_lattice_ : nullptr; }
  /// From a sample's depth to the farthest of what it fills. unit: slabs.
  double sampleReach() const;
  /// How far beyond its core a brick's samples are drawn. unit: voxels.
  std::int64_t ghosts() const { return ghosts_; }

  /// Where the samples of `box` fall, and perhaps more: pixels, not cut off at the image, and slabs of the zone.
  struct Bounds {
    PixelRect rect;
    int first = 0, last = -1;
    bool in_zone = false;  // all of them
    bool empty() const { return first > last || rect.empty(); }
  };
  Bounds boundsOf(const VoxelBox& box) const;

 private:
  const SlabZone& zone_;
  const Projector& projector_;
  const Extent3 dims_;
  const EndVoxels ends_;
  const SampleTable& table_;
  SampleLook look_;
  bool detailed_;
  FootprintTable footprint_;
  float color_unit_;
  UnitLattice lattice_;
  std::optional<UnitLattice> soft_lattice_;
  double voxel_length_;    // the mean of its edges. unit: world
  double shortest_edge_;   // the same
  double longest_sample_;  // along any axis. unit: world
  std::int64_t ghosts_;
};

/// A cell of a brick, or of its apron, that may hold something.
struct SlabCell {
  VoxelBox box;
  SlabFrame::Bounds bounds;
};

/// The cells of the brick that the transfer function shows, front to back. cost: a look at each cell's range; for a
/// cubic also at the voxels of cells beside one that is shown.
std::vector<SlabCell> interestingCells(const SlabFrame& frame, const BrickBlock& block);

}  // namespace kiln
