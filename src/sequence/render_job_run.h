// Runs one frame of a render job, from the volume to the picture on disk.
#pragma once

#include <span>

#include "base/progress.h"
#include "frame/statistics.h"
#include "image/image.h"
#include "job/render_job.h"
#include "store/bricked_volume.h"

namespace kiln {

struct RenderResult {
  Image image;                         // of two eyes, the left
  Camera camera;                       // with every choice made
  TransferFunction transfer_function;  // with every choice made
  RenderStatistics statistics;
};

/// Draws the first frame of the job `repeat` times, at least once, first with an empty cache, and writes the last
/// picture to the job's files, if any. With `skip_damaged`, each missing brick and their number are noted. throws:
/// Error kUsage, kBudget, kDamaged, kNotFound, kIo, kNoSpace, kCancelled.
RenderResult runRenderJob(const RenderJob& job, int repeat, Progress& progress);

/// Draws the first frame of the job from open volumes, such as arrays in memory (convert/open_array.h): the only volume
/// of the job, or as many as its `volumes`. The job's paths of volumes only name them. Memory that the volumes hold is
/// part of the job's memory. throws: as above; Error kUsage for another number of volumes.
RenderResult runRenderJob(const RenderJob& job, std::span<const BrickedVolume* const> volumes, Progress& progress);

/// Return camera and transfer function of a picture, resolved for a volume.
Camera cameraFor(const PictureOptions& picture, const BrickedVolume& volume);
TransferFunction transferFunctionFor(const PictureOptions& picture, const BrickedVolume& volume);

}  // namespace kiln
