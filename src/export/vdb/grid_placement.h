// The place of a level's voxels in a grid of OpenVDB.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "grid/openvdb_glue.h"
#include "store/store_reader.h"

namespace kiln {

/// Edge of a leaf of OpenVDB's trees. unit: voxels.
inline constexpr int kLeafLog2 = 3;
inline constexpr std::int64_t kLeafEdge = 1 << kLeafLog2;

/// Maps the voxels of a level to grid coordinates.
struct GridPlacement {
  std::string name = "density";
  VoxelCoord origin;
  glm::dmat4 world_from_grid{1.0};

  openvdb::Coord of(const VoxelCoord& v) const { return coordOf({v.x + origin.x, v.y + origin.y, v.z + origin.z}); }
};

/// Returns the name, coordinates and transform of the source's grid at level 0, else those of the level. throws: Error
/// kUnsupported, naming `out`, if OpenVDB has no such transform or coordinates.
GridPlacement placementOf(const StoreReader& store, int level, const std::filesystem::path& out);

}  // namespace kiln
