#include "traverse/frame_levels.h"

#include <algorithm>

namespace kiln {
namespace {

double longestHalvedEdge(const VolumeGeometry& geometry, const Extent3& span) {
  const glm::dvec3 spacing = geometry.spacing();
  double longest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (span[axis] > 1) longest = std::max(longest, spacing[axis]);
  }
  return longest;
}

EndVoxels endVoxelsOf(const Extent3& finest, const Extent3& dims, const Extent3& span) {
  EndVoxels out;
  for (int axis = 0; axis < 3; ++axis) {
    out.last[axis] = dims[axis] - 1;
    const std::int64_t covered = finest[axis] - out.last[axis] * span[axis];
    out.part[axis] = static_cast<double>(covered) / static_cast<double>(span[axis]);
  }
  return out;
}

}  // namespace

FrameLevels::FrameLevels(const Manifest& volume, std::optional<int> level, const View& view, ProjectedArea area,
                         const Clipping& clipping)
    : finest_(level.value_or(0)) {
  const int coarsest = level.value_or(static_cast<int>(volume.levels.size()) - 1);
  for (int l = finest_; l <= coarsest; ++l) {
    const VolumeGeometry& geometry = volume.levels[static_cast<std::size_t>(l)].geometry;
    const Extent3 span = volume.spanOf(l);
    // All levels of a frame share the near depth of the finest.
    const double near_depth = 0.5 * volume.levels[static_cast<std::size_t>(finest_)].geometry.shortestEdge();
    levels_.push_back({geometry.dims, Projector(geometry, view, area, near_depth),
                       endVoxelsOf(volume.geometry().dims, geometry.dims, span),
                       ClipRegion(clipping, volume.geometry(), span), span, longestHalvedEdge(geometry, span)});
  }
}

bool FrameLevels::fineEnough(int level, const VoxelBox& box) const {
  return level == finest_ || at(level).projector.largestPixels(at(level).edge, box) <= 1;
}

}  // namespace kiln
