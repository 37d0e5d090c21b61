// What the XML files and the legacy files of VTK have in common: the names of types, and the grid.
#pragma once

#include <optional>
#include <string_view>

#include "ingest/source/volume_source.h"

namespace kiln {

struct VtkTypeName {
  std::string_view name;
  VoxelType type;
};

/// Returns the type of a name in `names`; nothing for other names.
template <std::size_t kCount>
std::optional<VoxelType> vtkTypeNamed(const VtkTypeName (&names)[kCount], std::string_view name) {
  for (const VtkTypeName& known : names)
    if (known.name == name) return known.type;
  return std::nullopt;
}

/// Returns the geometry of the points of a grid, or of its cells, whose centres lie between the points.
/// shape: `extent` has the first and the last point of each axis; column a of `direction` is the direction of axis a.
/// throws: Error kUsage if --spacing is given for a grid that is turned; kFormat if the grid has no volume.
VolumeGeometry vtkGeometry(const std::filesystem::path& path, const std::array<std::int64_t, 6>& extent, bool of_cells,
                           const glm::dvec3& origin, const glm::dvec3& spacing, const glm::dmat3& direction,
                           const SourceOptions& options);

}  // namespace kiln
