#include "export/vdb/grid_placement.h"

#include <fmt/format.h>

#include <limits>

#include "base/error.h"

namespace kiln {

GridPlacement placementOf(const StoreReader& store, int level, const std::filesystem::path& out) {
  GridPlacement place;
  const VolumeGeometry& geometry = store.level(level).geometry;
  if (store.manifest().volume_class == VolumeClass::kLabels) place.name = "labels";
  place.world_from_grid = geometry.world_from_index;
  if (const auto& vdb = store.manifest().source.vdb) {
    place.name = vdb->grid_name;
    if (level == 0) {
      place.origin = vdb->index_origin;
      place.world_from_grid = vdb->world_from_grid;
    }
  }
  if (!hasTransform(place.world_from_grid)) {
    const glm::dvec3 edge = geometry.spacing(), origin = geometry.worldOf({0, 0, 0});
    throw Error(ErrorCode::kUnsupported, out, "geometry",
                fmt::format("OpenVDB has no transform for voxels of {:g} x {:g} x {:g} world units from ({:g}, {:g}, "
                            "{:g}) on; convert the source again with its lengths in a smaller unit",
                            edge.x, edge.y, edge.z, origin.x, origin.y, origin.z));
  }
  for (int axis = 0; axis < 3; ++axis) {
    constexpr std::int64_t kLo = std::numeric_limits<std::int32_t>::min(),
                           kHi = std::numeric_limits<std::int32_t>::max();
    if (place.origin[axis] < kLo || place.origin[axis] + geometry.dims[axis] - 1 > kHi) {
      throw Error(ErrorCode::kUnsupported, out, "", "the volume goes beyond OpenVDB's 32-bit coordinates");
    }
  }
  return place;
}

}  // namespace kiln
