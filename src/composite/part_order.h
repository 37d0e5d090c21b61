// Problem: sort partial images front to back. Method: box A is before box B where a ray could pass A first: along every
// axis that separates the boxes, the eye is on A's side. Differs: needs only boxes, no tree of cuts.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "grid/coords.h"
#include "grid/geometry.h"
#include "scene/camera/camera.h"

namespace kiln {

/// Returns indices into `boxes`, front to back; nothing if boxes hide one another in a cycle. requires: disjoint boxes
/// of voxels.
std::optional<std::vector<int>> frontToBack(std::span<const VoxelBox> boxes, const View& view,
                                            const VolumeGeometry& volume);

/// As frontToBack, for parts of a volume. throws: Error kUsage naming `first`, the place of the first part, if parts
/// hide one another in a cycle.
std::vector<int> requiredOrder(std::span<const VoxelBox> boxes, const View& view, const VolumeGeometry& volume,
                               const std::filesystem::path& first);

}  // namespace kiln
