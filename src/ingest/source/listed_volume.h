// The volumes of a file or folder, described by headers alone.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

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
  /// The option that chooses the volume, "--grid density"; empty if nothing is to be chosen.
  std::string option;
  /// The reason why the files are not read as one volume; empty if they are.
  std::string refusal;

  /// Size in memory; 0 if the size is unknown, UINT64_MAX if headers state more.
  std::uint64_t bytes() const;
};

/// Returns the name of a stack of files by its first and its last one. requires: at least one file.
std::string nameOfStack(const std::vector<std::filesystem::path>& stack);

}  // namespace kiln
