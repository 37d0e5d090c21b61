// The parts of a job that other documents have, too: a suite of measurements names cameras, materials and transfer
// functions by the same keys.
#pragma once

#include "job/job_json.h"
#include "job/render_job.h"

namespace kiln {

/// The `camera` of a job where it stands still; `more` are keys that somebody else reads. throws: Error kUsage naming
/// the key.
CameraSpec cameraFrom(const JobObject& object, JobKeys more = {});
/// The `shading` of a job. throws: as above.
Shading shadingFrom(const JobObject& object);

/// Reads a transfer function from a key of `owner`: a preset, a file beside the document, or the function itself;
/// nothing where the key is absent. throws: Error kUsage for other values.
std::optional<TransferFunctionChoice> transferFunctionChoiceFrom(const JobObject& owner,
                                                                 std::string_view key = "transferFunction");

/// The keys of `owner` that say what a picture shows; what is not there keeps its default. throws: as above.
Background backgroundFrom(const JobObject& owner);
std::vector<Light> lightsFrom(const JobObject& owner);
/// The planes of a list. throws: as above.
std::vector<ClipPlane> planesFrom(const JobObject& owner, std::string_view key);
/// `region` and `worldRegion`, which is six planes. throws: as above.
Clipping regionsFrom(const JobObject& owner);
/// Reads the region and the still planes of "clip". throws: as above.
Clipping clippingFrom(const JobObject& owner);
/// A half-open box of voxels.
std::optional<VoxelBox> voxelBoxFrom(const JobObject& owner, std::string_view key);
std::optional<Window> windowFrom(const JobObject& owner);
/// Three lengths. throws: as above.
std::optional<glm::dvec3> worldVectorFrom(const JobObject& owner, std::string_view key);

}  // namespace kiln
