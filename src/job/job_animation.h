// The keys of a job that stand still or change from frame to frame.
#pragma once

#include "job/job_json.h"
#include "job/render_job.h"

namespace kiln {

/// Each reads one key of a job's root, where it is there, into the still picture or into the animation.
/// throws: Error kUsage naming the key.
void readCamera(const JobObject& root, RenderJob& job);
void readStereo(const JobObject& root, RenderJob& job);
/// `still` and `keys` are of the volume that `owner` says this of.
void readTransferFunction(const JobObject& owner, TransferFunctionChoice& still,
                          std::vector<Key<TransferFunctionChoice>>& keys);
void readLights(const JobObject& root, RenderJob& job);
void readClipping(const JobObject& root, RenderJob& job);
void readFrames(const JobObject& root, RenderJob& job);

}  // namespace kiln
