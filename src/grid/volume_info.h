// Properties of a volume beside its voxels, read from a source and kept in a store.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <optional>
#include <string>
#include <vector>

#include "grid/coords.h"

namespace kiln {

/// Meaning of the values, if the source declares it; selects the default transfer function and the export type.
enum class VolumeClass { kUnknown, kFog, kLevelSet, kLabels };

/// Name and coordinates of the source's OpenVDB grid, restored by an export.
struct VdbOrigin {
  std::string grid_name;
  /// Grid coordinate of voxel (0,0,0).
  VoxelCoord index_origin;
  /// Maps grid coordinates to the world.
  glm::dmat4 world_from_grid{1.0};
};

/// A colour as screens show it (sRGB), and its opacity. unit: 255ths.
struct DisplayColor {
  std::uint8_t red = 255, green = 255, blue = 255, alpha = 255;
  bool operator==(const DisplayColor&) const = default;
};

/// The look that the author of a source gave the volume, which the default transfer function follows.
struct DeclaredLook {
  /// Values from black to a colour, linear on a screen.
  struct Ramp {
    double begin = 0, end = 1;
    DisplayColor color;
    bool operator==(const Ramp&) const = default;
  };
  struct Label {
    std::int64_t label = 0;
    DisplayColor color;
    bool operator==(const Label&) const = default;
  };

  /// For values that are amounts. shape: begin < end, finite.
  std::optional<Ramp> ramp;
  /// For labels. shape: sorted by label, unique.
  std::vector<Label> labels;

  bool empty() const { return !ramp && labels.empty(); }
  bool operator==(const DeclaredLook&) const = default;
};

}  // namespace kiln
