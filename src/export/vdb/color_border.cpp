#include "export/vdb/color_border.h"

#include <openvdb/tools/Morphology.h>

namespace kiln {

ColorBorder::ColorBorder(const openvdb::Vec3SGrid& grid) : voxels_(grid.tree(), false, openvdb::TopologyCopy()) {
  openvdb::tools::dilateActiveValues(voxels_, 1, openvdb::tools::NN_FACE_EDGE_VERTEX, openvdb::tools::PRESERVE_TILES);
  voxels_.topologyDifference(grid.tree());
}

std::uint64_t ColorBorder::bytes() const {
  using Leaf = openvdb::Vec3STree::LeafNodeType;
  return voxels_.leafCount() * (sizeof(Leaf) + Leaf::SIZE * sizeof(openvdb::Vec3f));
}

void ColorBorder::fill(openvdb::Vec3SGrid& grid) const {
  const openvdb::Vec3SGrid::ConstAccessor known = grid.getConstAccessor();
  openvdb::Vec3SGrid::Accessor colors = grid.getAccessor();
  for (auto voxel = voxels_.cbeginValueOn(); voxel; ++voxel) {
    const openvdb::Coord at = voxel.getCoord();
    openvdb::Vec3f sum(0);
    int count = 0;
    for (int i = 0; i < 27; ++i) {
      const openvdb::Coord beside = at.offsetBy(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      openvdb::Vec3f color;
      if (known.probeValue(beside, color)) sum += color, ++count;
    }
    // Active voxels are the grid's own until all means are found.
    if (count > 0) colors.setValueOff(at, sum / static_cast<float>(count));
  }
  grid.tree().topologyUnion(voxels_);
}

}  // namespace kiln
