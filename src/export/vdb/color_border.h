// Colours beside the active voxels of a grid.
// Problem. A renderer interpolates density and colour each by itself. The colour of an empty voxel counts beside a
// visible voxel, and black there darkens surfaces.
// Method. Each voxel that touches an active voxel gets the mean colour of its active neighbours, and becomes active.
// Invariant. The result does not depend on the order of bricks. No active voxel changes.
#pragma once

#include <cstdint>

#include "grid/openvdb_glue.h"

namespace kiln {

class ColorBorder {
 public:
  /// Finds the voxels beside active voxels. requires: the grid does not change until `fill`.
  explicit ColorBorder(const openvdb::Vec3SGrid& grid);

  /// Memory that `fill` adds to the grid, at most. unit: bytes.
  std::uint64_t bytes() const;
  void fill(openvdb::Vec3SGrid& grid) const;

 private:
  openvdb::MaskTree voxels_;
};

}  // namespace kiln
