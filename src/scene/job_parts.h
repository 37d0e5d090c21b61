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

/// The keys of `owner` that say what a picture shows; what is not there keeps its default. throws: as above.
Background backgroundFrom(const JobObject& owner);
std::vector<Light> lightsFrom(const JobObject& owner);
Clipping clippingFrom(const JobObject& owner);
std::optional<Window> windowFrom(const JobObject& owner);
/// Three lengths. throws: as above.
std::optional<glm::dvec3> worldVectorFrom(const JobObject& owner, std::string_view key);

}  // namespace kiln
