// The default number of samples a pixel: several if voxels are smaller than pixels and the picture stays cheap.
#pragma once

#include <vector>

#include "job/render_job.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// Returns the default number of samples a pixel: 1, 4 or 16.
/// - The number makes voxels of the finest level at least three quarters of a sub-pixel, with several volumes the
///   finest volume's voxels.
/// - The voxels of all levels in view must not exceed kMostOversampledVoxels, sub-pixels not kMostSubPixels.
/// - A moving camera gets 4 samples below 4 pixels a voxel, against flicker; with labels alone below 5/4.
/// - The voxel lattice, projected values, panoramas and deep images have one sample.
/// The size of a voxel is taken at `centre`, so that a camera around the centre keeps its number. Crop, memory, threads
/// and bricks do not matter. unit: `centre` world. throws: Error kUsage for an unusable camera.
int automaticSamples(const RenderJob& job, const Camera& camera, const glm::dvec3& centre,
                     const std::vector<const Manifest*>& volumes);

/// Limit of a picture's sub-pixels: 4096².
inline constexpr std::int64_t kMostSubPixels = std::int64_t{1} << 24;

}  // namespace kiln
