#include "open_brick.h"

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#include <stdexcept>

namespace kiln::test {
namespace {

template <class Grid>
bool copyVoxels(const openvdb::GridBase& base, BrickGrid& out) {
  const auto* grid = dynamic_cast<const Grid*>(&base);
  if (grid == nullptr) return false;
  out.background = static_cast<double>(grid->background());
  for (auto value = grid->cbeginValueOn(); value; ++value) {
    if (!value.isVoxelValue()) throw std::runtime_error("an active tile");
    const openvdb::Coord c = value.getCoord();
    out.active.emplace_back(VoxelCoord{c.x(), c.y(), c.z()}, static_cast<double>(*value));
  }
  return true;
}

}  // namespace

std::vector<BrickGrid> openBrick(const std::filesystem::path& path) {
  openvdb::initialize();
  openvdb::io::File file(path.string());
  file.open(/*delayLoad=*/false);
  std::vector<BrickGrid> out;
  const openvdb::GridPtrVecPtr grids = file.getGrids();
  for (const openvdb::GridBase::Ptr& grid : *grids) {
    BrickGrid brick;
    brick.name = grid->getName();
    brick.value_type = grid->valueType();
    // Where the transform takes the origin and the three unit steps: the affine, column by column.
    const openvdb::Vec3d origin = grid->indexToWorld(openvdb::Vec3d(0, 0, 0));
    for (int column = 0; column < 3; ++column) {
      openvdb::Vec3d step(0, 0, 0);
      step[column] = 1;
      const openvdb::Vec3d edge = grid->indexToWorld(step) - origin;
      brick.world_from_index[column] = glm::dvec4(edge[0], edge[1], edge[2], 0);
    }
    brick.world_from_index[3] = glm::dvec4(origin[0], origin[1], origin[2], 1);
    if (!copyVoxels<openvdb::FloatGrid>(*grid, brick) && !copyVoxels<openvdb::DoubleGrid>(*grid, brick) &&
        !copyVoxels<openvdb::Int32Grid>(*grid, brick) && !copyVoxels<openvdb::Int64Grid>(*grid, brick)) {
      throw std::runtime_error("a grid of " + grid->valueType());
    }
    out.push_back(std::move(brick));
  }
  return out;
}

}  // namespace kiln::test
