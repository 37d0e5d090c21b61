// The default number of samples a pixel: more than one where voxels are smaller than pixels and the picture stays
// cheap.
#pragma once

#include <vector>

#include "job/render_job.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// So many (1, 4 or 16) that voxels of the finest level, of several volumes of the finest, are three quarters of a
/// sub-pixel or more, as far as the voxels of every level that they show are at most kMostOversampledVoxels, and
/// sub-pixels kMostSubPixels. One for the voxel lattice, projected values, panoramas and deep images. Where the camera
/// moves, 4 also where voxels are smaller than 4 pixels, so that pictures do not flicker; of labels alone below 5/4.
/// Judged at `centre`, so that no camera that goes round it changes it; neither crop, nor memory, threads or bricks do.
/// unit: `centre` world. throws: Error kUsage where the camera cannot be used.
int automaticSamples(const RenderJob& job, const Camera& camera, const glm::dvec3& centre,
                     const std::vector<const Manifest*>& volumes);

/// Limit of a picture's sub-pixels: 4096².
inline constexpr std::int64_t kMostSubPixels = std::int64_t{1} << 24;

}  // namespace kiln
