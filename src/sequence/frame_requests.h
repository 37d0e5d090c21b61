// Requests of frames, made of the options of a job.
#pragma once

#include "frame/pass/frame_request.h"
#include "job/frame/frame_scene.h"
#include "job/render_job.h"

namespace kiln {

/// Return the request of a frame. Without a number of samples a pixel has one sample; scenes always have a number
/// (SceneOfJob).
FrameRequest requestOf(const FrameScene& scene, const SpeedOptions& speed);
FrameRequest frameRequest(const PictureOptions& picture, const SpeedOptions& speed, const Camera& camera,
                          const TransferFunction& transfer_function);

}  // namespace kiln
