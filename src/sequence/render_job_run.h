// A render job from the store to the picture on disk.
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
  Image image;                         // of both eyes, the left's
  Camera camera;                       // with every choice made
  TransferFunction transfer_function;  // the same
  RenderStatistics statistics;
};

/// Draws the first frame of the job `repeat` times (the first with a cold cache) and writes the last to the job's
/// files, if it names any. With `skip_damaged` what is missing is noted: a sentence a brick, and how many. throws:
/// Error kUsage, kBudget, kDamaged, kNotFound, kIo, kNoSpace, kCancelled.
RenderResult runRenderJob(const RenderJob& job, int repeat, Progress& progress);

/// The camera, the transfer function and the rest of a picture, resolved for a volume.
Camera cameraFor(const PictureOptions& picture, const StoreReader& store);
TransferFunction transferFunctionFor(const PictureOptions& picture, const StoreReader& store);
/// Where nobody says how many samples a pixel has, it has one; a scene says (SceneOfJob).
FrameRequest frameRequest(const RenderJob& job, const Camera& camera, const TransferFunction& transfer_function);
FrameRequest requestOf(const FrameScene& scene, const SpeedOptions& speed);
FrameRequest frameRequest(const PictureOptions& picture, const SpeedOptions& speed, const Camera& camera,
                          const TransferFunction& transfer_function);

}  // namespace kiln
