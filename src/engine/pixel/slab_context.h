// State shared by all bricks and tiles of a zone of slabs, computed once per frame, and the visible cells of a brick in
// the zone.
#pragma once

#include <vector>

#include "engine/pixel/cut_faces.h"
#include "engine/pixel/sample_faces.h"
#include "engine/pixel/voxels/load_patch.h"
#include "engine/pixel/voxels/sample_table.h"
#include "engine/shared/shade.h"
#include "engine/shared/slab_grid.h"
#include "scene/clip_region.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// Appearance of a level's samples beyond the table. requires: referenced objects outlive all users.
struct Appearance {
  Shading shading;
  Shader shader;  // belongs to the level
  const ClipRegion* clip = nullptr;
  GradientSense gradients;
  Interpolation interpolation = Interpolation::kLinear;
  bool surfaces = false;                // samples are crossings of surfaces
  const SampleTable* colors = nullptr;  // colours of a companion's values; null: the volume's own
  const CutFaces* faces = nullptr;      // cut faces that show values; null: none
};

/// A zone of slabs with its level, table and appearance.
class SlabContext {
 public:
  /// requires: all arguments outlive the context; `projector` belongs to the zone's level, `dims` are the level's
  /// voxels.
  SlabContext(const SlabZone& zone, const Projector& projector, const Extent3& dims, const SampleTable& table,
              const Appearance& look);
  SlabContext(const SlabContext&) = delete;
  SlabContext& operator=(const SlabContext&) = delete;

  const SlabZone& zone() const { return zone_; }
  const Projector& projector() const { return projector_; }
  const Extent3& dims() const { return dims_; }
  const SampleTable& table() const { return table_; }
  /// Returns true if samples that interpolate `range`, or stand for values in `range`, may be visible.
  bool interesting(const ValueRange& range) const { return table_.interesting(range); }
  /// Returns true if no sample in the voxels' cubes reaches into the clip region and the drawn part.
  bool cutOff(const VoxelBox& samples) const;
  /// Returns true if a cut face that looks at the eye may pass through the voxels' cubes.
  bool onFace(const VoxelBox& voxels) const;
  /// Returns true if such a face shows values of `range`, whatever the table says of them.
  bool coloursFace(const VoxelBox& voxels, const ValueRange& range) const;
  /// Faces that end or light samples.
  const std::vector<SampleFace>& faces() const { return faces_; }
  /// Faces of faces() that light samples. Surfaces have no cut faces; faces that show values are samples of their own.
  const std::vector<SampleFace>& lightFaces() const { return light_faces_; }
  /// Returns true if a single sample may replace two in a cell with values in `range`.
  bool inPairs(const SampledRange& range) const;
  const Appearance& look() const { return look_; }
  const SampleLattice& lattice() const { return lattice_; }

  /// Conservative rectangle of the pixels whose rays may have samples of the zone in the voxels' cubes; not clipped to
  /// the image.
  PixelRect boundsOf(const VoxelBox& box) const;

 private:
  const SlabZone& zone_;
  const Projector& projector_;
  const Extent3 dims_;
  const SampleTable& table_;
  Appearance look_;
  bool clipped_;
  SampleLattice lattice_;
  std::vector<SampleFace> faces_, light_faces_;
  std::vector<glm::dvec4> shown_faces_;  // cut faces that show values and look at the eye, in index space
  double voxel_length_;                  // mean edge of a voxel. unit: world
  double shortest_edge_;                 // shortest edge of a voxel. unit: world
};

/// A visible cell of a brick and the pixels it may touch.
struct SlabCell {
  VoxelBox box;
  PixelRect rect;
};

/// Returns the cells of the brick that the transfer function or a cut face shows, front to back. cost: one range test
/// per cell; a cubic also reads the voxels of cells next to a visible cell.
std::vector<SlabCell> visibleCells(const SlabContext& context, const BrickBlock& block);

}  // namespace kiln
