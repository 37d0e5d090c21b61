// The visible part of a volume as a user gives it: a box of voxels, half-spaces of the world, a part by number.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "grid/coords.h"

namespace kiln {

/// Shows points with normal·x + offset >= 0, x in the world. requires: a normal of finite, positive length.
struct ClipPlane {
  glm::dvec3 normal{0, 0, 1};
  double offset = 0;
  bool operator==(const ClipPlane&) const = default;
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
