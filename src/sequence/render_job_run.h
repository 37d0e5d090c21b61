// Runs one frame of a render job, from the store to the picture on disk.
#pragma once

#include "base/progress.h"
#include "frame/render_frame.h"
#include "frame/statistics.h"
#include "image/image.h"
#include "job/frame_scene.h"
#include "job/render_job.h"
#include "store/store_reader.h"

namespace kiln {

struct RenderResult {
  Image image;                         // of two eyes, the left
  Camera camera;                       // with every choice made
  TransferFunction transfer_function;  // with every choice made
  RenderStatistics statistics;
};

/// Draws the first frame of the job `repeat` times, first with an empty cache, and writes the last picture to the job's
/// files, if any. With `skip_damaged`, each missing brick and their number are noted. throws: Error kUsage, kBudget,
/// kDamaged, kNotFound, kIo, kNoSpace, kCancelled.
RenderResult runRenderJob(const RenderJob& job, int repeat, Progress& progress);

/// Return camera and transfer function of a picture, resolved for a volume.
Camera cameraFor(const PictureOptions& picture, const StoreReader& store);
TransferFunction transferFunctionFor(const PictureOptions& picture, const StoreReader& store);
/// Return the request of a frame. Without a number of samples a pixel has one sample; scenes always have a number
/// (SceneOfJob).
FrameRequest frameRequest(const RenderJob& job, const Camera& camera, const TransferFunction& transfer_function);
FrameRequest requestOf(const FrameScene& scene, const SpeedOptions& speed);
FrameRequest frameRequest(const PictureOptions& picture, const SpeedOptions& speed, const Camera& camera,
                          const TransferFunction& transfer_function);

}  // namespace kiln
