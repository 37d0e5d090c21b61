// A decoded brick for the kernels: core and apron in one dense array of the source's type, and the brick's part of the
// min-max octree. OpenVDB is only the container on disk.
#pragma once

#include <cstddef>
#include <vector>

#include "base/memory/large_pages.h"
#include "grid/coords.h"
#include "grid/voxel_type.h"
#include "store/codec/shown_voxels.h"
#include "store/ranges/cell_supports.h"
#include "store/ranges/minmax_octree.h"

namespace kiln {

/// The stored voxels of a brick: core and apron, clipped at the volume.
inline VoxelBox storedBox(const VoxelBox& core, std::int64_t apron, const Extent3& dims) {
  return intersection(dilated(core, apron), boxOf(dims));
}

struct BrickBlock {
  BrickKey key;
  VoxelType type = VoxelType::u8;
  /// Global index coordinates of the core's voxels.
  VoxelBox core;
  /// Global index coordinates of all voxels in `voxels`: the core grown by the apron. Voxels outside the volume repeat
  /// the nearest voxel of the volume.
  VoxelBox extent;
  /// shape: extent, x fastest, densely packed.
  UnsetBytes voxels;
  MinMaxOctree octree;
  CellSupports supports;
  /// Voxels of `extent` that a mask shows (companion/label_mask.h); all without a mask.
  ShownVoxels shown;
  /// Values of another volume at the voxels of `extent` (companion/color_values.h), NaN outside that volume; empty
  /// without such a volume. shape: as `voxels`.
  std::vector<float> color_values;
  /// Brick files of companions that were read to make the block, and their size. unit: bytes.
  std::uint64_t companion_reads = 0, companion_bytes = 0;
  /// True if a mask hides all voxels; the brick's own file was then not read.
  bool masked = false;
  /// True if the volume's own voxels have one value and no file, whatever its companions hold.
  bool constant = false;

  std::int64_t strideY() const { return extent.extent().x; }
  std::int64_t strideZ() const { return extent.extent().x * extent.extent().y; }
  /// Memory of the block. unit: bytes.
  std::size_t bytes() const {
    return sizeof *this + voxels.size() + octree.bytes() + supports.bytes() + shown.bytes() +
           color_values.size() * sizeof(float);
  }

  template <class T>
  const T* data() const {
    return reinterpret_cast<const T*>(voxels.data());
  }
  /// Index into `data()` of the voxel at `v`. requires: v in extent.
  std::int64_t offsetOf(const VoxelCoord& v) const {
    return (v.x - extent.lo.x) + (v.y - extent.lo.y) * strideY() + (v.z - extent.lo.z) * strideZ();
  }
};

}  // namespace kiln
