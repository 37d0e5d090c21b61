// A brick file as a stranger's program sees it: opened with OpenVDB alone, by name, with nothing of Kiln's.
#pragma once

#include <filesystem>
#include <glm/mat4x4.hpp>
#include <string>
#include <utility>
#include <vector>

#include "grid/coords.h"

namespace kiln::test {

struct BrickGrid {
  std::string name;
  std::string value_type;  // "float", "int32", "int64", "double"
  glm::dmat4 world_from_index{1.0};
  double background = 0;
  /// Active voxels with their values, in the tree's order; no tile stands for any of them.
  std::vector<std::pair<VoxelCoord, double>> active;
};

/// All grids of an OpenVDB file. throws: openvdb::Exception.
std::vector<BrickGrid> openBrick(const std::filesystem::path& path);

}  // namespace kiln::test
