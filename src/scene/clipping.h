// The visible part of a volume as a user gives it: a box of voxels, half-spaces of the world, a part by number; and the
// look of its cut faces.
#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "grid/coords.h"

namespace kiln {

/// Shows points with normal·x + offset >= 0, x in the world. requires: a normal of finite, positive length.
struct ClipPlane {
  glm::dvec3 normal{0, 0, 1};
  double offset = 0;
  bool operator==(const ClipPlane&) const = default;
};

/// Look of the faces through which rays enter the visible part: the values there, without light.
struct Section {
  /// Colour map of the values (scene/transfer/display_map.h); empty: colours of the transfer function, and nothing
  /// where its opacity is 0.
  std::string color_map;
  /// Centre and width of the values that the map covers; absent: the middle 99 % of the values.
  std::optional<glm::dvec2> window;
  double opacity = 1;  // 0..1
  bool operator==(const Section&) const = default;
};

/// Shows points that satisfy all members; the default shows everything.
struct Clipping {
  std::optional<VoxelBox> region;  // of level 0
  std::vector<ClipPlane> planes;
  /// A box of level 0 for a partial image. Not a cut: voxels beside the box still serve interpolation and footprints,
  /// so that the partial images of boxes that fill the volume compose to the whole picture.
  std::optional<VoxelBox> part = {};
  /// Number of leading planes that are the faces of a box of the world, which options replace separately.
  std::size_t box_faces = 0;
  std::optional<Section> section = {};  // absent: cut faces show samples like other places
  /// Compares the visible part only.
  bool operator==(const Clipping& other) const {
    return region == other.region && planes == other.planes && part == other.part;
  }
};

/// One of `count` parts of a volume (scene/volume_part.h). Index from 1 to `count`.
struct PartNumber {
  int index = 1, count = 1;
  bool operator==(const PartNumber&) const = default;
};

}  // namespace kiln
