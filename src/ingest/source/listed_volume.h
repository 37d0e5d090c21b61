// The volumes of a file or folder, described by headers alone.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "grid/coords.h"
#include "grid/voxel_type.h"

namespace kiln {

struct ListedVolume {
  /// The name of a grid, the identifier of a series, or the name of a file, of pages or of slices.
  std::string name;
  /// The kind of object: "level set", "CT 'Thin slices'".
  std::string kind;
  /// Empty if the headers do not state them.
  std::optional<Extent3> dims;
  std::optional<VoxelType> type;
  /// The option that chooses it, "--grid density"; empty if nothing is to be chosen.
  std::string option;
  /// The reason why it is not read as one volume; empty if it is.
  std::string refusal;

  /// Size in memory; 0 if it is unknown.
  std::uint64_t bytes() const { return dims && type ? static_cast<std::uint64_t>(dims->count()) * sizeOf(*type) : 0; }
};

}  // namespace kiln
