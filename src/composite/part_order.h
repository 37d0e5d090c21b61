// The order in which partial images hide one another.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "grid/coords.h"
#include "grid/geometry.h"
#include "scene/camera/camera.h"

namespace kiln {

/// The parts' places in `boxes`, front to back: one is before another where a ray could pass it first. Nothing where
/// some hide one another in turn. requires: boxes of voxels of the volume, without a common voxel.
std::optional<std::vector<int>> frontToBack(std::span<const VoxelBox> boxes, const View& view,
                                            const VolumeGeometry& volume);

}  // namespace kiln
