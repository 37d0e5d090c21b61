// How partial images are put together (DESIGN §8): which is before which, and one pixel over another.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

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

/// Puts `behind` behind `front`, as slabs are laid behind each other (splat/lay_sheet.cpp): what the parts in front do
/// not cover of a pixel is clear. A pixel that reaches the threshold is divided by its alpha and closed, as when it is
/// drawn. Associative within rounding and what the threshold leaves open.
inline void layBehind(const PartPixel& behind, float opaque_at, PartPixel& front) {
  if (front.rgba[3] == 1.0f || !(behind.covered > 0)) return;
  const float density = front.covered > 0 ? std::min(front.rgba[3] / front.covered, 1.0f) : 0.0f;
  const float seen = (behind.covered - std::min(behind.covered, front.covered) * density) / behind.covered;
  for (int c = 0; c < 4; ++c) front.rgba[c] += seen * behind.rgba[c];
  front.covered = std::max(front.covered, behind.covered);
  if (front.rgba[3] < opaque_at) return;
  for (int c = 0; c < 3; ++c) front.rgba[c] /= front.rgba[3];
  front.rgba[3] = 1.0f;
}

}  // namespace kiln
