// Reads the options of a job with a still value or a value that changes from frame to frame.
#pragma once

#include "job/json/job_json.h"
#include "job/render_job.h"

namespace kiln {

/// Each reads an object or a key that is there into the still picture or into the animation.
/// throws: Error kUsage naming the key.
void readCamera(const JobObject& camera, RenderJob& job);
void readStereo(const JobObject& stereo, RenderJob& job);
/// Reads the `transferFunction` of `owner` into the choice of a volume and its keys.
void readTransferFunction(const JobObject& owner, TransferFunctionChoice& still,
                          std::vector<Key<TransferFunctionChoice>>& keys);
void readLights(const JobObject& root, RenderJob& job);
void readClipPlanes(const JobObject& root, RenderJob& job);
void readFrames(const JobObject& root, RenderJob& job);

/// The paths of a camera.
Turntable turntableFrom(const JobObject& object);
CameraKeyframes cameraKeyframesFrom(const JobObject& camera);
CameraMatrices matricesFrom(const JobObject& camera);

}  // namespace kiln
