// The parts of a job that other documents have, too: a suite of measurements names cameras, materials and transfer
// functions by the same keys.
#pragma once

#include "scene/job_json.h"
#include "scene/render_job.h"

namespace kiln {

/// The `camera` of a job. throws: Error kUsage naming the key.
CameraSpec cameraFrom(const JobObject& object);
/// The `shading` of a job. throws: as above.
Shading shadingFrom(const JobObject& object);

/// What the key `transferFunction` of `owner` says: a preset, a file beside the document, or the function itself; empty
/// where the key is not there. throws: Error kUsage where it is none of them.
std::optional<TransferFunctionChoice> transferFunctionChoiceFrom(const JobObject& owner);

/// The key `window` of `owner`. throws: as above.
std::optional<Window> windowFrom(const JobObject& owner);

}  // namespace kiln
