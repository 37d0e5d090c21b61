// Common to the XML files and the legacy files of VTK: the names of types, the choice of an array, and the grid.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ingest/bytes/stored_type.h"
#include "ingest/source/volume_source.h"

namespace kiln {

struct VtkTypeName {
  std::string_view name;
  StoredType type;
};

/// Returns the type of a name in `names`; nothing for other names.
template <std::size_t kCount>
std::optional<StoredType> vtkTypeNamed(const VtkTypeName (&names)[kCount], std::string_view name) {
  for (const VtkTypeName& known : names)
    if (known.name == name) return known.type;
  return std::nullopt;
}

/// An array of a file, as its header describes the array.
struct VtkArray {
  std::string name;
  /// As written: "UInt16", "unsigned_short".
  std::string type_text;
  /// Nothing for a type that is not read.
  std::optional<StoredType> type;
  std::int64_t components = 1;
  bool of_cells = false;
  /// True if the file marks the array as the scalars that programs show first.
  bool is_active = false;

  /// True if the array has one value a point or cell.
  bool isReadable() const { return components == 1 && type; }
};

struct VtkChoice {
  /// The index of the array.
  std::size_t index = 0;
  /// ", channel 1": the array for SourceInfo::format; empty if the file decides.
  std::string part;
  /// Names the arrays that are not read; empty if there are none, or the user chose.
  std::string note;
};

/// Chooses the array that the user names, else the first active one, else the only readable one.
/// throws: Error kUnsupported if none is readable; kUsage if several are and none is chosen, or the chosen one is not
/// there.
VtkChoice chosenVtkArray(const std::vector<VtkArray>& arrays, const SourceOptions& options,
                         const std::filesystem::path& path);

/// Returns the geometry of the points of a grid, or of its cells, whose centres lie between the points.
/// shape: `extent` has the first and the last point of each axis; column a of `direction` is the direction of axis a.
/// throws: Error kUsage if --spacing is given for a grid that is turned; kFormat if the grid has no volume.
VolumeGeometry vtkGeometry(const std::filesystem::path& path, const std::array<std::int64_t, 6>& extent, bool of_cells,
                           const glm::dvec3& origin, const glm::dvec3& spacing, const glm::dmat3& direction,
                           const SourceOptions& options);

}  // namespace kiln
