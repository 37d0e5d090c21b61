// How partial images are put together (DESIGN §8): which is before which, and one pixel over another.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "base/edge_layers.h"
#include "grid/coords.h"
#include "grid/geometry.h"
#include "scene/camera.h"

namespace kiln {

/// The parts' places in `boxes`, front to back: one is before another where a ray could pass it first. Nothing where
/// some hide one another in turn. requires: boxes of voxels of the volume, without a common voxel.
std::optional<std::vector<int>> frontToBack(std::span<const VoxelBox> boxes, const View& view,
                                            const VolumeGeometry& volume);

/// Light, alpha, and what slabs cover of the pixel's area (splat/coverage.h).
struct PartPixel {
  float rgba[4] = {}, covered = 0;
};

/// Puts `behind` behind `front`, as slabs are laid behind each other. A pixel that reaches the threshold is divided by
/// its alpha and closed, as when it is drawn.
inline void layBehind(const EdgeLayer& behind, float opaque_at, PartPixel& front) {
  if (front.rgba[3] == 1.0f) return;
  layBehind(behind, front.rgba, front.covered);
  if (front.rgba[3] < opaque_at) return;
  for (int c = 0; c < 3; ++c) front.rgba[c] /= front.rgba[3];
  front.rgba[3] = 1.0f;
}

/// The same of all that a part shows in a pixel, as if it were one slab: exact where that part's first slab covers all
/// of the pixel; at edges its layers say more.
inline void layBehind(const PartPixel& behind, float opaque_at, PartPixel& front) {
  if (!(behind.covered > 0)) return;
  EdgeLayer layer{behind.covered, {}};
  for (std::size_t c = 0; c < 4; ++c) layer.rgba[c] = behind.rgba[c] / behind.covered;
  layBehind(layer, opaque_at, front);
}

}  // namespace kiln
